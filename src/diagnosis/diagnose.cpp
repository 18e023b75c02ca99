#include "diagnosis/diagnose.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "diagnosis/locate.hpp"
#include "diagnosis/model_selection.hpp"
#include "diagnosis/parameter_bias.hpp"
#include "diagnosis/verdict.hpp"
#include "recording/checks.hpp"
#include "recording/crank_current.hpp"
#include "recording/deep_discharge.hpp"

namespace battery_sof {
namespace {

void requireValid(const DiagnoseOptions& options) {
  if (!(options.holdout_share > 0.0) || !(options.holdout_share <= 0.5))
    throw std::invalid_argument("holdout_share is " + std::to_string(options.holdout_share) +
                                ", expected above 0 and at most 0.5");
  if (options.threads < 0)
    throw std::invalid_argument("threads is " + std::to_string(options.threads) +
                                ", expected at least 0");
  const Relevance& relevance = options.relevance;
  for (const auto& [name, value] : {std::pair<const char*, double>{"min-rmse", relevance.rmse},
                                    {"min-crank", relevance.crank},
                                    {"min-charge", relevance.charge_share}})
    if (!(value >= 0.0) || !std::isfinite(value))
      throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) +
                                  ", expected finite and at least 0");
  for (const std::vector<std::string>* list : {&options.hypotheses, &options.given})
    for (const std::string& id : *list) effectInfo(id);
}

/// No instrument's fault, and no effect's either: a fact that a reader must know first.
void addDeepDischarge(Diagnosis& found, const Series& series) {
  const std::string deep = findDeepDischarges(series).toString(1.0);
  if (!deep.empty()) found.instrument.insert(found.instrument.begin(), deep);
}

Diagnosis insufficient(const Series& series, const std::string& lack, const EventLimits& limits) {
  Diagnosis found;
  found.outside = outsideWhatSignalsShow();
  found.summary = "This recording cannot be diagnosed: " + lack + ".";
  addDeepDischarge(found, series);
  found.source = detectControlMode(series, limits);
  found.next_experiment = nextExperiment(found);
  return found;
}

}  // namespace

Diagnosis diagnose(const Recording& recording, const DiagnoseOptions& given) {
  requireValid(given);
  DiagnoseOptions options = given;
  options.crank_current = crankCurrentOf(recording.series, given.crank_current).current;
  const EventLimits limits{*options.crank_current};
  const Parts parts = partsOf(recording.series, options.holdout_share);
  std::optional<std::string> lack =
      lackOf(slice(recording.series, parts.train), options.holdout_share, options.anyway);
  // The sign and the units of a file may not show in the training part alone.
  if (!lack && !options.anyway) {
    const std::vector<Finding> problems = findProblems(recording);
    if (!problems.empty()) lack = format(problems);
  }
  if (lack) return insufficient(recording.series, *lack, limits);
  const Residuals residuals = residualsOf(recording, parts, options);
  if (residuals.lack) return insufficient(recording.series, *residuals.lack, limits);
  Diagnosis found;
  found.outside = outsideWhatSignalsShow();
  found.instrument = residuals.screened.sentences;
  addDeepDischarge(found, recording.series);
  tell(options, "locating where model and measurement deviate");
  const std::vector<Regime> regimes = regimesOf(residuals.quiet, limits);
  found.regimes = regimeFindings(residuals.base, residuals.quiet, regimes);
  found.parameter_bias = parameterBiases(residuals.base, residuals.quiet, regimes);
  const ModelSelection selected = selectModel(recording, residuals, options, found);
  const std::optional<ChargerControl>& driving = selected.explained.driving;
  const InputSequence rows = driving ? rowsOf(residuals, driving) : residuals.quiet;
  found.mismatch =
      mismatchSegments(rows, residuals.base.point, driving ? regimesOf(rows, limits) : regimes,
                       options.relevance.rmse, options.pulse);
  validate(recording, residuals, selected, options, found);
  for (FittedModel* model : {&found.base, &found.extended})
    model->fit.nominal_capacity = options.capacity;
  found.summary = summaryOf(found);
  found.next_experiment = nextExperiment(found, residuals.screened.skew);
  return found;
}

MechanismEvidence mechanismEvidence(const Recording& recording) {
  DiagnoseOptions options;
  options.crank_current = findCrankCurrent(recording.series).current;
  const Parts parts = partsOf(recording.series, options.holdout_share);
  if (!lackOf(slice(recording.series, parts.train), options.holdout_share)) return {};
  const Residuals residuals = residualsOf(recording, parts, options);
  return residuals.lack ? MechanismEvidence{} : weighMechanisms(residuals);
}

}  // namespace battery_sof
