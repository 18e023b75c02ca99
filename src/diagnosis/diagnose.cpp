#include "diagnosis/diagnose.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "diagnosis/locate.hpp"
#include "diagnosis/validation.hpp"
#include "diagnosis/verdict.hpp"

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
  for (const auto& [name, value] : {std::pair<const char*, double>{"rmse", relevance.rmse},
                                    {"crank", relevance.crank},
                                    {"charge_share", relevance.charge_share}})
    if (!(value >= 0.0) || !std::isfinite(value))
      throw std::invalid_argument("relevance." + std::string(name) + " is " +
                                  std::to_string(value) + ", expected finite and at least 0");
  for (const std::vector<std::string>* list :
       {&options.hypotheses, &options.given, &options.confirm})
    for (const std::string& id : *list) effectInfo(id);
}

Diagnosis insufficient(const Series& series, const std::string& lack) {
  Diagnosis found;
  found.outside = outsideWhatSignalsShow();
  found.verdict = Verdict::kInsufficientData;
  found.summary = "The recording cannot answer: " + lack + ".";
  found.source = detectControlMode(series);
  found.charger_share = found.source.share;
  found.next_experiment = nextExperiment(found);
  return found;
}

void take(Diagnosis& found, const Explained& explained, EstimatedDiscrepancy discrepancy,
          Judged judged) {
  found.evidence_base = explained.explanation.base_evidence;
  found.evidence_extended = explained.explanation.evidence;
  found.effective_sample_fraction = explained.explanation.effective_sample_fraction;
  found.unexplained = discrepancy.unexplained;
  found.discrepancy = std::move(discrepancy.finding);
  found.verdict = judged.verdict;
  found.mechanism = judged.mechanism;
  found.probability = judged.probability;
  found.mechanisms = std::move(judged.mechanisms);
  if (explained.is_lead_acid) found.mechanism_evidence = judged.evidence;
  found.candidates = std::move(judged.candidates);
  found.detection_limits = std::move(judged.detection_limits);
}

void take(Diagnosis& found, Named named, Validation validation) {
  found.base = std::move(named.base);
  found.effects = std::move(named.effects);
  found.extended = std::move(validation.extended);
  found.base_voltage = std::move(validation.base_voltage);
  found.extended_voltage = std::move(validation.extended_voltage);
  found.fit = std::move(validation.fit);
  found.source = std::move(validation.source);
  found.charger_share = found.source.share;
  found.withheld_rmse = validation.withheld_rmse;
  if (found.withheld_rmse && found.discrepancy) found.discrepancy->is_used = false;
  for (Candidate& candidate : found.candidates)
    if (candidate.rejected_because.empty())
      candidate.holdout_gain_percent = validation.holdout_gain_percent;
}

}  // namespace

Diagnosis diagnose(const Recording& recording, const DiagnoseOptions& options) {
  requireValid(options);
  const Parts parts = partsOf(recording.series, options.holdout_share);
  const std::string lack = lackOf(slice(recording.series, parts.train), options.holdout_share);
  if (!lack.empty()) return insufficient(recording.series, lack);
  Residuals residuals = residualsOf(recording, parts, options);
  ModelSelection selected = selectModel(recording, residuals, options);
  Validation validation = validate(recording, residuals, selected, options);

  Diagnosis found;
  found.outside = outsideWhatSignalsShow();
  for (const std::vector<std::string>* notes :
       {&residuals.notes, &selected.explained.notes, &validation.notes})
    found.instrument.insert(found.instrument.end(), notes->begin(), notes->end());
  found.mismatch =
      mismatchSegments(residuals.base, selected.last.quiet, residuals.regimes,
                       selected.last.at_edges ? residuals.base.noise : selected.last.fit.noise);
  found.regimes = std::move(residuals.findings);
  found.parameter_bias = std::move(residuals.parameter_bias);
  take(found, selected.explained, std::move(selected.discrepancy), std::move(selected.judged));
  take(found, std::move(selected.named), std::move(validation));
  found.summary = summaryOf(found);
  found.next_experiment = nextExperiment(found);
  return found;
}

MechanismEvidence mechanismEvidence(const Recording& recording, const DiagnoseOptions& options) {
  requireValid(options);
  const Parts parts = partsOf(recording.series, options.holdout_share);
  if (!lackOf(slice(recording.series, parts.train), options.holdout_share).empty()) return {};
  return weighMechanisms(residualsOf(recording, parts, options), options);
}

}  // namespace battery_sof
