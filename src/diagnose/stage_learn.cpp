#include "stage_learn.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "battery_sof/diagnose/verdict.hpp"
#include "battery_sof/recording/number_text.hpp"
#include "battery_sof/recording/words.hpp"

namespace battery_sof {
namespace {

constexpr int kLeftOutBlocks = 4;
constexpr std::size_t kTermsTold = 4;

/// A fit with a force beside it, as it was learnt.
WhitenedFit composedWith(const WhitenedFit& beside, std::shared_ptr<const LearnedForce> force) {
  WhitenedFit fit = beside;
  fit.model = withForce(beside.model, std::move(force));
  fit.point.parameters = withFactors(fit.model, beside.point.parameters);
  return fit;
}

/// Ids of columns in words, those of most weight first.
std::vector<std::string> heaviestTerms(const LearnedForce& force) {
  std::vector<std::pair<double, std::string>> terms;
  for (Eigen::Index k = 0; k < force.weight.size(); ++k)
    terms.push_back({std::abs(force.weight[k]), describe(force.columns[static_cast<std::size_t>(k)])});
  std::stable_sort(terms.begin(), terms.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> told;
  for (const auto& term : terms)
    if (told.size() < kTermsTold && !contains(told, term.second)) told.push_back(term.second);
  return told;
}

void describeLearned(LearnedFinding& learned) {
  learned.answers = answersOf(learned.force, learned.answer_current);
  learned.terms = heaviestTerms(learned.force);
  learned.description = sentence(
      "What the currents and their memory say beside the equations moves the voltage by %.1f mV RMS and takes "
      "the error on left-out blocks from %.1f to %.1f mV.",
      1e3 * learned.rms, 1e3 * learned.left_out.base, 1e3 * learned.left_out.force);
}

/// A force beside a fit. Columns with a clock of their own have a part in it where blocks that are left out are missed by less with them.
/// @param fit of the force, its noise and gain are left in it.
LearnedFinding learnBeside(const WhitenedFit& beside, const Prepared& prepared, const DiagnoseOptions& options, ForceFit& fit) {
  const Drive full = fullDrive(prepared.screened.series, prepared.parts.train, prepared.screened.limits.masked);
  const ModelPoint beginning = beginningOf(beside.point, full);
  BaseResponse response = baseResponse(beside.model, beginning, full, full.samples.size());
  pulse(options);
  takeForceDirections(response, beside.model, beginning, full);
  pulse(options);
  const ForceTable table = forceTable(full, response, beside.point.parameters[kRowBeta]);
  LearnedFinding learned;
  pulse(options);
  learned.left_out = leftOutErrors(response, table, kLeftOutBlocks, isTimeless);
  pulse(options);
  const LeftOutErrors with_clocks = leftOutErrors(response, table, kLeftOutBlocks);
  const bool takes_clocks = with_clocks.force < learned.left_out.force;
  if (takes_clocks) learned.left_out = with_clocks;
  pulse(options);
  fit = learnForce(response, table, takes_clocks ? ColumnFilter() : isTimeless);
  learned.force = std::move(fit.force);
  learned.families = std::move(fit.families);
  learned.rms = fit.rms;
  return learned;
}

}  // namespace

Learned learnRest(const Prepared& prepared, const Explained& explained, const FinalFit& last, const DiagnoseOptions& options) {
  const Explanation& explanation = explained.explanation;
  const WhitenedFit& beside = explained.driving ? prepared.base : last.fit;
  ForceFit fit;
  LearnedFinding finding = learnBeside(beside, prepared, options, fit);
  Learned learned;
  learned.left = {explanation.left_rms, explanation.left_crank, explanation.left_charge_share, options.relevance};
  learned.left.limits.rmse = explanation.relevant;
  learned.left.noise = explanation.noise;
  const bool matters = finding.rms >= std::max(options.relevance.rmse, 0.5 * fit.noise);
  // Where nothing else came in, it alone would be the alarm: it takes as much evidence as any other component.
  const bool is_evident = !explanation.components.empty() || fit.gain >= ExplanationRules().least_gain;
  finding.is_used = matters && is_evident && finding.left_out.force < finding.left_out.base;
  if (!finding.is_used && finding.left_out.base <= kPlausible) return learned;
  describeLearned(finding);
  if (finding.is_used) learned.with_force = composedWith(beside, std::make_shared<const LearnedForce>(finding.force));
  const std::vector<double>& current = prepared.screened.series.current;
  const auto [least, most] = std::minmax_element(current.begin(), current.begin() + static_cast<std::ptrdiff_t>(prepared.parts.train.last));
  finding.curve = curveOf(finding.force, *least, *most);
  learned.finding = std::move(finding);
  return learned;
}

}  // namespace battery_sof
