#include "bag/battery_state_message.hpp"
#include "message_parts.hpp"
#include "ros/message_conversion.hpp"

namespace battery_sof {
namespace {

DiagnosisMetrics metricsOf(const ErrorMetrics& metrics) {
  DiagnosisMetrics message;
  message.q_dyn_percent = metrics.q_dyn_percent;
  message.rmse = metrics.rmse;
  message.max_abs = metrics.max_abs;
  message.crank_mae = orNan(metrics.crank_mae);
  message.charge_bias = orNan(metrics.charge_bias);
  message.charge_current_error = orNan(metrics.charge_current_error);
  return message;
}

DiagnosisEffect effectOf(const NamedEffect& effect) {
  DiagnosisEffect message;
  message.id = effect.id;
  message.confidence = effect.confidence;
  message.mechanism = effect.mechanism;
  message.probability = effect.probability;
  message.evidence = effect.evidence;
  message.voltage_rms = effect.voltage_rms;
  message.biased_parameters = effect.biased_parameters;
  message.indistinguishable_from = effect.indistinguishable_from;
  for (const DiagnosedParameter& parameter : effect.parameters) {
    DiagnosisParameter one;
    one.name = parameter.name;
    one.unit = parameter.unit;
    one.value = parameter.value;
    one.std = orNan(parameter.std);
    one.lower = orNan(parameter.lower);
    one.upper = orNan(parameter.upper);
    one.at_bound = parameter.at_bound;
    message.parameters.push_back(one);
  }
  return message;
}

DiagnosisCandidate candidateOf(const Candidate& candidate) {
  DiagnosisCandidate message;
  message.id = candidate.id;
  message.mechanism = candidate.mechanism;
  message.evidence = candidate.evidence;
  message.holdout_gain_percent = orNan(candidate.holdout_gain_percent);
  message.confidence = candidate.confidence;
  message.rejected_because = candidate.rejected_because;
  return message;
}

DiagnosisSegment segmentOf(const MismatchSegment& segment) {
  DiagnosisSegment message;
  message.from = segment.from;
  message.to = segment.to;
  message.regime = segment.regime;
  message.mean_error = segment.mean_error;
  message.peak_error = segment.peak_error;
  message.p_value = segment.p_value;
  return message;
}

void fillComparison(DiagnosisMessage& message, const Comparison& fit) {
  message.train_from = fit.train.from;
  message.train_to = fit.train.to;
  message.holdout_from = fit.holdout.from;
  message.holdout_to = fit.holdout.to;
  message.base_train = metricsOf(fit.base_train);
  message.base_holdout = metricsOf(fit.base_holdout);
  message.extended_train = metricsOf(fit.extended_train);
  message.extended_holdout = metricsOf(fit.extended_holdout);
}

/// What a diagnosis that compared nothing has: no numbers.
void clearComparison(DiagnosisMessage& message) {
  Comparison none;
  for (ErrorMetrics* metrics :
       {&none.base_train, &none.base_holdout, &none.extended_train, &none.extended_holdout})
    metrics->q_dyn_percent = metrics->rmse = metrics->max_abs = kNan;
  fillComparison(message, none);
  message.train_from = message.train_to = message.holdout_from = message.holdout_to = kNan;
}

}  // namespace

DiagnosisMessage messageOf(const DiagnosisReport& report, const Adoption& adoption) {
  const Diagnosis& diagnosis = *report.diagnosis;
  DiagnosisMessage message;
  message.header.stamp = rosTime(report.to);
  message.from = report.from;
  message.samples = static_cast<std::uint32_t>(report.samples);
  message.duration_ms = report.duration_ms;
  message.verdict = toString(diagnosis.verdict);
  message.summary = diagnosis.summary;
  message.mechanism = diagnosis.mechanism() ? mechanismId(*diagnosis.mechanism()) : "";
  message.probability = diagnosis.probability();
  message.unexplained_rmse = diagnosis.unexplained.rmse;
  for (const NamedEffect& effect : diagnosis.effects) message.effects.push_back(effectOf(effect));
  for (const Candidate& candidate : diagnosis.candidates)
    message.candidates.push_back(candidateOf(candidate));
  for (const MismatchSegment& segment : diagnosis.mismatch)
    message.mismatch.push_back(segmentOf(segment));
  message.instrument = diagnosis.instrument;
  message.unobservable = diagnosis.outside;
  if (diagnosis.fit.train.samples > 0) {
    fillComparison(message, diagnosis.fit);
  } else {
    clearComparison(message);
  }
  message.next_experiment = diagnosis.next_experiment;
  message.adopted = !adoption.effects.empty();
  message.adoption = adoption.sentence;
  return message;
}

DiagnoseResult resultOf(const DiagnosisOutcome& outcome) {
  DiagnoseResult result;
  result.success = outcome.message.has_value();
  result.code = result.success ? DiagnoseResult::OK : DiagnoseResult::FAILED;
  result.message = result.success ? outcome.message->summary : outcome.fault;
  if (result.success) result.diagnosis = *outcome.message;
  return result;
}

}  // namespace battery_sof
