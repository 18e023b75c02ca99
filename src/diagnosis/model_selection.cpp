#include "diagnosis/model_selection.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "diagnosis/score_selection.hpp"
#include "diagnosis/verdict.hpp"
#include "estimation/depth_physics.hpp"
#include "explanation_fits.hpp"
#include "recording/channel_statistics.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

// [s] of a slow training part: the courses of hours are told apart by left-out blocks
constexpr double kLongAndSlow = 4500.0;
constexpr double kLowestVoltage = 10.5, kHighestVoltage = 15.5;  // [V] a block of lead-acid cells
constexpr double kNominalVoltage = 12.8;                         // [V]

/// Whether a voltage is that of blocks of six lead-acid cells, one or more in a row.
bool isLeadAcid(const Series& series) {
  const double middle = quantile(series.voltage, 0.5);
  const double blocks = std::round(middle / kNominalVoltage);
  return blocks >= 1.0 && middle >= blocks * kLowestVoltage && middle <= blocks * kHighestVoltage;
}

/// @return ids that a diagnosis weighs: those asked for, else all of the catalogue; what is weighed
/// on request alone takes part where a source controls the voltage, which is what it is for. What
/// needs a charge that moved far is left to selectByScore().
std::vector<std::string> hypothesesOf(const std::vector<std::string>& asked,
                                      bool voltage_controlled) {
  if (!asked.empty()) return asked;
  std::vector<std::string> ids;
  for (const EffectInfo& info : effectCatalogue())
    if ((!info.on_request || voltage_controlled) && !contains(info.needs, kMovedByCharge))
      ids.push_back(info.id);
  return ids;
}

/// Ids to weigh. @param notes says why there are none.
std::vector<std::string> idsToWeigh(const std::vector<std::string>& wanted, bool is_driven,
                                    bool is_lead_acid, std::vector<std::string>& notes) {
  if (wanted.empty() && !is_lead_acid) {
    notes.push_back(
        "the voltage is not that of lead-acid blocks, so what is missing is estimated from the "
        "data, and no lead-acid effect is named");
    return {};
  }
  return hypothesesOf(wanted, is_driven);
}

std::unique_ptr<ExplanationFits> fitsTo(const Residuals& residuals,
                                        const std::optional<ChargerControl>& driving,
                                        const DiagnoseOptions& options) {
  return std::make_unique<ExplanationFits>(rowsOf(residuals, driving), residuals.base.point,
                                           options);
}

/// How identify() fits the training part as it was recorded.
IdentifyOptions identifyOptions(const Series& train, const std::optional<ChargerControl>& screened,
                                const DiagnoseOptions& options) {
  const InstrumentLimits limits = instrumentLimits(train);
  IdentifyOptions fit;
  fit.crank_current = options.crank_current.value_or(kCrankCurrent);
  takeInstrument(fit, train, limits);
  fit.source = screened;
  if (std::optional<ChargerControl> as_recorded =
          screened ? chargerControl(train, std::nullopt, EventLimits{fit.crank_current})
                   : std::nullopt)
    fit.source = std::move(as_recorded);
  fit.priors = options.priors;
  fit.more_starts = 0;
  return fit;
}

/// Effects are those that predict left-out blocks; the rows are linearised there for what regressors
/// say of mechanisms and of the rest.
/// @param train as it was recorded: circuit and effects are what identify() makes of it.
void explainByScore(const Series& train, const IdentifyOptions& fit,
                    const std::vector<std::string>& ids, const DiagnoseOptions& options,
                    ExplanationFits& fits, Explained& explained) {
  tell(options, "testing effects by the blocks that they predict");
  ScoreSelection selection = selectByScore(train, {0, train.size()}, fit, ids, options);
  tell(options, "comparing mechanisms");
  explained.explanation =
      explanationAround(fits, optimumOf(selection.circuit), compositionOf(selection.extended.fit),
                        optimumOf(selection.extended), options);
  Explanation& explanation = explained.explanation;
  explanation.terms = selection.terms;
  explanation.weighed = selection.weighed;
  for (const SelectedTerm& term : explanation.terms) explanation.evidence += term.gain;
  explained.by_blocks = true;
  explained.circuit = std::move(selection.circuit);
  explained.extended = std::move(selection.extended);
}

/// Evidence decides on effects, and what is compared is what identify() makes of the training part
/// without and with them.
/// @param train as it was recorded.
void explainByEvidence(const Series& train, const IdentifyOptions& fit, const Residuals& residuals,
                       const std::vector<std::string>& ids, const DiagnoseOptions& options,
                       ExplanationFits& fits, Explained& explained) {
  const auto fitted = [](const Series& series, const IdentifyOptions& how) {
    FittedModel model = identify(series, {0, series.size()}, how);
    return isUsable(model.fit) ? std::optional(std::move(model)) : std::nullopt;
  };
  explained.circuit = fitted(train, fit);
  explained.explanation = explain(fits, ids, options);
  if (!explained.hasEffects()) return;
  IdentifyOptions composed = fit;
  composed.effects = explained.explanation.model.effects();
  composed.starts = {explained.explanation.point};
  explained.extended = fitted(slice(residuals.screened.series, residuals.parts.train), composed);
}

/// A source is taken to control the voltage where the rows are missed by a tenth less so, once all
/// that can be estimated is taken out: a rest or a step that one channel shows late can look like a
/// source, and a voltage that is controlled although it is not brings its noise into the battery's
/// state. Effects are weighed by left-out blocks there, and where sampling is slow over hours; by
/// evidence elsewhere.
Explained explainErrors(const Recording& recording, const Residuals& residuals,
                        const DiagnoseOptions& options, std::vector<std::string>& notes) {
  Explained explained;
  explained.driving =
      chargerControl(residuals.screened.series, std::nullopt, EventLimits{residuals.crank_current});
  explained.is_lead_acid = isLeadAcid(residuals.screened.series);
  std::unique_ptr<ExplanationFits> fits = fitsTo(residuals, std::nullopt, options);
  if (explained.driving) {
    std::unique_ptr<ExplanationFits> controlled = fitsTo(residuals, explained.driving, options);
    if (controlled->minError() < (1.0 - kCatalogueTolerance) * fits->minError()) {
      fits = std::move(controlled);
    } else {
      explained.driving.reset();
      notes.push_back(
          "a source was detected, but the error is no smaller if it is taken to hold the voltage, "
          "so the current is the input");
    }
  }
  const std::vector<std::string> ids =
      idsToWeigh(options.hypotheses, explained.driving.has_value(), explained.is_lead_acid, notes);
  const Series train = slice(recording.series, residuals.parts.train);
  const double span = train.time.back() - train.time.front();
  const IdentifyOptions fit = identifyOptions(train, explained.driving, options);
  if (explained.driving || (residuals.screened.slow && span > kLongAndSlow && !ids.empty())) {
    explainByScore(train, fit, ids, options, *fits, explained);
  } else {
    explainByEvidence(train, fit, residuals, ids, options, *fits, explained);
  }
  return explained;
}

/// What a discrepancy is estimated in addition to.
Optimum withoutDiscrepancy(const Explained& explained, const Residuals& residuals) {
  const std::optional<FittedModel>& fitted =
      explained.extended ? explained.extended : explained.circuit;
  if (!fitted || explained.by_blocks) return {residuals.base.model, residuals.base.point};
  return {compositionOf(fitted->fit), optimumOf(*fitted)};
}

constexpr int kDiscrepancyBlocks = 4;
constexpr std::size_t kReportedTerms = 4;

/// An optimum with a discrepancy, as it was estimated.
Optimum composedWith(const Optimum& without, std::shared_ptr<const DiscrepancyModel> discrepancy) {
  const BatteryModel model = withDiscrepancy(without.model, std::move(discrepancy));
  return {model, {withFactors(model, without.point.parameters), without.point.state}};
}

/// A curve that bends beyond the currents that were driven is a line within them.
std::string termText(const Regressor& regressor, const DrivenTime& driven) {
  const bool is_curve =
      regressor.kind == RegressorKind::kCompressed || regressor.kind == RegressorKind::kSaturating;
  const bool is_reached = driven(regressor.scale) > 0.0 || driven(-regressor.scale) > 0.0;
  return is_curve && !is_reached ? "a line in the current" : toString(regressor);
}

/// Ids of regressors in words, those of most weight first.
std::vector<std::string> heaviestTerms(const DiscrepancyModel& discrepancy,
                                       const DrivenTime& driven) {
  std::vector<std::pair<double, std::string>> terms;
  for (Eigen::Index k = 0; k < discrepancy.weight.size(); ++k)
    terms.push_back({std::abs(discrepancy.weight[k]), termText(discrepancy.regressors[k], driven)});
  std::stable_sort(terms.begin(), terms.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> words;
  for (const auto& term : terms)
    if (words.size() < kReportedTerms && !contains(words, term.second))
      words.push_back(term.second);
  return words;
}

/// @param driven in the training part: what it did not hold, no answer is given for.
void describeDiscrepancy(DiscrepancyFinding& discrepancy, const DrivenTime& driven) {
  discrepancy.answer_current = answerCurrentOf(driven);
  if (discrepancy.answer_current)
    discrepancy.answers = answersOf(discrepancy.discrepancy, *discrepancy.answer_current, driven);
  discrepancy.curve = curveOf(discrepancy.discrepancy, driven);
  discrepancy.terms = heaviestTerms(discrepancy.discrepancy, driven);
  discrepancy.description = format(
      "The discrepancy, a function of the currents and their memory, moves the voltage by %.1f mV "
      "RMS. On left-out blocks it changes the error from %.1f to %.1f mV.",
      1e3 * discrepancy.rms, 1e3 * discrepancy.left_out.base,
      1e3 * discrepancy.left_out.discrepancy);
}

/// A discrepancy added to a fit. Regressors with a clock of their own have a part in it where they
/// reduce the error on left-out blocks.
/// @param fit set here: the caller reads its noise and gain.
DiscrepancyFinding fitWithDiscrepancy(const Optimum& without, const Residuals& residuals,
                                      const DiagnoseOptions& options, DiscrepancyFit& fit) {
  const InputSequence full = rowsOf(residuals, std::nullopt);
  const ModelPoint beginning = without.point.at(full.first_time);
  const Linearization response =
      discrepancyLinearizationOf(without.model, beginning, full, full.samples.size());
  pulse(options);
  const DesignMatrix table = designMatrix(full, response, without.point.parameters[kRowBeta]);
  DiscrepancyFinding discrepancy;
  pulse(options);
  discrepancy.left_out = leftOutErrors(response, table, kDiscrepancyBlocks, isTimeless);
  pulse(options);
  const LeftOutErrors with_clocks = leftOutErrors(response, table, kDiscrepancyBlocks);
  const bool takes_clocks = with_clocks.discrepancy < discrepancy.left_out.discrepancy;
  if (takes_clocks) discrepancy.left_out = with_clocks;
  pulse(options);
  fit = fitDiscrepancy(response, table, takes_clocks ? RegressorFilter() : isTimeless);
  discrepancy.discrepancy = std::move(fit.discrepancy);
  discrepancy.mechanisms = std::move(fit.mechanisms);
  discrepancy.rms = fit.rms;
  return discrepancy;
}

/// The discrepancy of the voltage by currents and their memory, checked on blocks left out.
/// @param found takes it where it is used or needed.  @return the model with it, where it is used.
std::optional<Optimum> estimateDiscrepancy(const Residuals& residuals, const Explained& explained,
                                           const DiagnoseOptions& options, Diagnosis& found) {
  const Explanation& explanation = explained.explanation;
  const Optimum without = withoutDiscrepancy(explained, residuals);
  DiscrepancyFit fit;
  DiscrepancyFinding finding = fitWithDiscrepancy(without, residuals, options, fit);
  const bool is_relevant = finding.rms >= std::max(options.relevance.rmse, 0.5 * fit.noise);
  // Where nothing else was selected, it alone would be the finding: it needs as much evidence as
  // any other component.
  const bool is_evident = !explanation.terms.empty() || fit.gain >= kMinGain;
  finding.is_used =
      is_relevant && is_evident && finding.left_out.discrepancy < finding.left_out.base;
  if (!finding.is_used && finding.left_out.base <= kPlausible) return std::nullopt;
  describeDiscrepancy(finding, drivenTimeOf(residuals.screened.series, residuals.parts.train));
  found.discrepancy = std::move(finding);
  // Effects that left-out blocks decided on stand for themselves.
  if (!found.discrepancy->is_used ||
      (explained.by_blocks && (explained.driving || explained.hasEffects())))
    return std::nullopt;
  return composedWith(without,
                      std::make_shared<const DiscrepancyModel>(found.discrepancy->discrepancy));
}

}  // namespace

InputSequence rowsOf(const Residuals& residuals, const std::optional<ChargerControl>& driving) {
  const Screening& screened = residuals.screened;
  if (!driving)
    return inputSequence(screened.series, residuals.parts.train, screened.limits.masked);
  std::vector<char> masked = screened.limits.masked;
  for (std::size_t n = 0; n < masked.size(); ++n)
    masked[n] = masked[n] || driving->repair.dropped[n];
  return inputSequence(repaired(screened.series, driving->repair), residuals.parts.train, masked,
                       driving->voltage_controlled);
}

MechanismEvidence weighMechanisms(const Residuals& residuals) {
  return mechanismEvidence(*fitsTo(residuals, std::nullopt, {}), hypothesesOf({}, false));
}

ModelSelection selectModel(const Recording& recording, const Residuals& residuals,
                           const DiagnoseOptions& options, Diagnosis& found) {
  ModelSelection selected;
  selected.explained = explainErrors(recording, residuals, options, found.instrument);
  const Explanation& explanation = selected.explained.explanation;
  found.evidence_base = explanation.base_evidence;
  found.evidence_extended = explanation.evidence;
  found.effective_sample_fraction = explanation.effective_sample_fraction;
  found.unexplained = explanation.unexplained;
  tell(options, "estimating what no equation represents");
  selected.with_discrepancy = estimateDiscrepancy(residuals, selected.explained, options, found);
  pulse(options);
  judgeFindings(recording, residuals, options, selected, found);
  return selected;
}

}  // namespace battery_sof
