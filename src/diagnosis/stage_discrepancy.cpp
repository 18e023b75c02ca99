#include "stage_discrepancy.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "diagnosis/verdict.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kLeftOutBlocks = 4;
constexpr std::size_t kReportedTerms = 4;

/// A fit with a discrepancy, as it was estimated.
WhitenedFit composedWith(const WhitenedFit& without,
                         std::shared_ptr<const DiscrepancyModel> discrepancy) {
  WhitenedFit fit = without;
  fit.model = withDiscrepancy(without.model, std::move(discrepancy));
  fit.point.parameters = withFactors(fit.model, without.point.parameters);
  return fit;
}

/// Ids of regressors in words, those of most weight first.
std::vector<std::string> heaviestTerms(const DiscrepancyModel& discrepancy) {
  std::vector<std::pair<double, std::string>> terms;
  for (Eigen::Index k = 0; k < discrepancy.weight.size(); ++k)
    terms.push_back({std::abs(discrepancy.weight[k]),
                     toString(discrepancy.regressors[static_cast<std::size_t>(k)])});
  std::stable_sort(terms.begin(), terms.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> words;
  for (const auto& term : terms)
    if (words.size() < kReportedTerms && !contains(words, term.second))
      words.push_back(term.second);
  return words;
}

void describeDiscrepancy(DiscrepancyFinding& discrepancy) {
  discrepancy.answers = answersOf(discrepancy.discrepancy, discrepancy.answer_current);
  discrepancy.terms = heaviestTerms(discrepancy.discrepancy);
  discrepancy.description = format(
      "The discrepancy, a function of the currents and their memory, moves the voltage by %.1f mV "
      "RMS. On left-out blocks the error goes from %.1f to %.1f mV.",
      1e3 * discrepancy.rms, 1e3 * discrepancy.left_out.base,
      1e3 * discrepancy.left_out.discrepancy);
}

/// A discrepancy added to a fit. Regressors with a clock of their own have a part in it where they
/// reduce the error on left-out blocks.
/// @param fit of the discrepancy, its noise and gain are left in it.
DiscrepancyFinding fitWithDiscrepancy(const WhitenedFit& without, const Prepared& prepared,
                                      const DiagnoseOptions& options, DiscrepancyFit& fit) {
  const InputSequence full = inputSequence(prepared.screened.series, prepared.parts.train,
                                           prepared.screened.limits.masked);
  const ModelPoint beginning = beginningOf(without.point, full);
  Linearization response = linearizationOf(without.model, beginning, full, full.samples.size());
  pulse(options);
  takeDiscrepancyDirections(response, without.model, beginning, full);
  pulse(options);
  const DesignMatrix table = designMatrix(full, response, without.point.parameters[kRowBeta]);
  DiscrepancyFinding discrepancy;
  pulse(options);
  discrepancy.left_out = leftOutErrors(response, table, kLeftOutBlocks, isTimeless);
  pulse(options);
  const LeftOutErrors with_clocks = leftOutErrors(response, table, kLeftOutBlocks);
  const bool takes_clocks = with_clocks.discrepancy < discrepancy.left_out.discrepancy;
  if (takes_clocks) discrepancy.left_out = with_clocks;
  pulse(options);
  fit = fitDiscrepancy(response, table, takes_clocks ? RegressorFilter() : isTimeless);
  discrepancy.discrepancy = std::move(fit.discrepancy);
  discrepancy.mechanisms = std::move(fit.mechanisms);
  discrepancy.rms = fit.rms;
  return discrepancy;
}

}  // namespace

EstimatedDiscrepancy estimateDiscrepancy(const Prepared& prepared, const Explained& explained,
                                         const FinalFit& last, const DiagnoseOptions& options) {
  const Explanation& explanation = explained.explanation;
  DiscrepancyFit fit;
  DiscrepancyFinding finding = fitWithDiscrepancy(last.fit, prepared, options, fit);
  EstimatedDiscrepancy discrepancy;
  discrepancy.unexplained = {explanation.unexplained_rms, explanation.unexplained_crank,
                             explanation.unexplained_charge_share, options.relevance};
  discrepancy.unexplained.limits.rmse = explanation.relevant;
  discrepancy.unexplained.noise = explanation.noise;
  const bool is_relevant = finding.rms >= std::max(options.relevance.rmse, 0.5 * fit.noise);
  // Where nothing else was selected, it alone would be the finding: it needs as much evidence as
  // any other component.
  const bool is_evident = !explanation.terms.empty() || fit.gain >= ExplanationRules().min_gain;
  finding.is_used =
      is_relevant && is_evident && finding.left_out.discrepancy < finding.left_out.base;
  if (!finding.is_used && finding.left_out.base <= kPlausible) return discrepancy;
  describeDiscrepancy(finding);
  if (finding.is_used)
    discrepancy.with_discrepancy =
        composedWith(last.fit, std::make_shared<const DiscrepancyModel>(finding.discrepancy));
  const std::vector<double>& current = prepared.screened.series.current;
  const auto [least, most] = std::minmax_element(
      current.begin(), current.begin() + static_cast<std::ptrdiff_t>(prepared.parts.train.last));
  finding.curve = curveOf(finding.discrepancy, *least, *most);
  discrepancy.finding = std::move(finding);
  return discrepancy;
}

}  // namespace battery_sof
