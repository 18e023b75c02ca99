#include "battery_sof/ros/message_conversion.hpp"

#include <cmath>
#include <limits>

#include "battery_sof/bag/battery_state_message.hpp"
#include "battery_sof/report/model_yaml.hpp"

namespace battery_sof {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double orNan(const std::optional<double>& value) { return value.value_or(kNan); }

constexpr Interval kNoInterval{kNan, kNan, kNan};

std::uint8_t stateCode(SessionState state) {
  switch (state) {
    case SessionState::kNoSample:
      return SofStatus::NO_DATA;
    case SessionState::kCollecting:
      return SofStatus::COLLECTING;
    case SessionState::kIdentifying:
      return SofStatus::IDENTIFYING;
    case SessionState::kReady:
      return SofStatus::READY;
    case SessionState::kStale:
      return SofStatus::STALE;
  }
  return SofStatus::NO_DATA;
}

std::uint8_t codeOf(AnswerCode code) { return static_cast<std::uint8_t>(code); }

/// A number that a request may leave out.
double orDefault(double value, double standard) {
  return std::isnan(value) || value == 0.0 ? standard : value;
}

std::optional<double> required(double u_required) {
  return std::isnan(u_required) ? std::nullopt : std::optional<double>(u_required);
}

/// The fields that a service's response and the standing answer of the status share.
template <typename Message>
void fillAnswer(Message& message, const CrankingAnswer& answer) {
  const Interval u_min = answer.u_min.value_or(kNoInterval);
  message.u_min = u_min.value;
  message.lower = u_min.lower;
  message.upper = u_min.upper;
  message.capable = answer.capable.value_or(false);
  message.valid = answer.valid;
  message.code = codeOf(answer.code);
  message.message = answer.message;
}

void fillStandingQuestion(SofStatus& message, const StandingQueries& standing) {
  const CrankingQuery& query = standing.cranking;
  message.i_load = query.i_load;
  message.t_stop = query.t_stop;
  message.i_cranking = query.i_cranking;
  message.t_cranking = query.t_cranking;
  message.u_required = orNan(query.u_required);
  message.u_boost = standing.charge.u_boost;
  message.t_sof2 = standing.charge.t_sof2;
  message.i_limit = standing.charge.i_limit;
}

void fillContest(SofStatus& message, const SessionStatus& session) {
  message.effects = session.effects;
  message.extension = session.extension;
  message.contest_duration = session.contest ? session.contest->duration : kNan;
  message.base_rmse = session.contest ? session.contest->base_rmse : kNan;
  message.extended_rmse = session.contest ? session.contest->extended_rmse : kNan;
}

void fillStopTime(SofStatus& message, const std::optional<StopTimeAnswer>& asked) {
  StopTimeAnswer not_asked;
  not_asked.code = AnswerCode::kInvalidQuery;
  not_asked.message = "u_required is not given";
  const PredictStopTime::Response answer = responseOf(asked.value_or(not_asked));
  message.stop_time = answer.t_stop;
  message.stop_time_lower = answer.lower;
  message.stop_time_upper = answer.upper;
  message.stop_time_outcome = answer.outcome;
  message.stop_time_monotone = answer.monotone;
  message.stop_time_valid = answer.valid;
  message.stop_time_code = answer.code;
  message.stop_time_message = answer.message;
}

void fillCharge(SofStatus& message, const ChargeAcceptanceAnswer& answer) {
  const Interval i_boost = answer.i_boost.value_or(kNoInterval);
  message.i_boost = i_boost.value;
  message.i_boost_lower = i_boost.lower;
  message.i_boost_upper = i_boost.upper;
  message.i_boost_valid = answer.valid;
  message.i_boost_code = codeOf(answer.code);
  message.i_boost_message = answer.message;
}

void fillCranks(SofStatus& message, const EventTallies& events) {
  const CrankComparison shown =
      events.last_crank.value_or(CrankComparison{kNan, kNan, kNan, kNoInterval, kNan, {}, false});
  message.cranks = static_cast<std::uint32_t>(events.cranks.count);
  message.crank_time = shown.time;
  message.crank_current = shown.current;
  message.crank_measured = shown.measured_minimum;
  message.crank_expected = shown.expected_minimum.value;
  message.crank_lower = shown.expected_minimum.lower;
  message.crank_upper = shown.expected_minimum.upper;
  message.cranks_inside_share = orNan(events.cranks.insideShare());
  message.cranks_mean_abs_error = orNan(events.cranks.meanAbsError());
  message.crank_interval_factor = events.crank_scale.factor;
}

void fillCharges(SofStatus& message, const EventTallies& events) {
  const ChargeComparison shown =
      events.last_charge.value_or(ChargeComparison{kNan, kNan, kNan, kNan, kNan, kNoInterval, kNan, {}, false});
  message.charges = static_cast<std::uint32_t>(events.charges.count);
  message.charge_time = shown.time;
  message.charge_duration = shown.duration;
  message.charge_voltage = shown.mean_voltage;
  message.charge_measured = shown.measured_current;
  message.charge_expected = shown.expected_current.value;
  message.charge_lower = shown.expected_current.lower;
  message.charge_upper = shown.expected_current.upper;
  message.charges_inside_share = orNan(events.charges.insideShare());
  message.charges_mean_abs_error = orNan(events.charges.meanAbsError());
  message.charge_interval_factor = events.charge_scale.factor;
}

const char* nameOf(const NaiveScore& contest) { return contest.naive_answers ? "naive" : "model"; }

void fillSourceAndNaive(SofStatus& message, const StatusContents& contents) {
  message.source_seen = contents.session.source_seen;
  message.source_share = orNan(contents.session.source_share);
  message.voltage_drives = contents.session.voltage_drives;
  const ExpectedSample expected = contents.session.expected.value_or(ExpectedSample{kNan, std::nullopt, std::nullopt});
  message.expected_time = expected.time;
  message.expected_voltage = orNan(expected.voltage);
  message.expected_current = orNan(expected.current);
  message.naive_crank_mean_abs_error = orNan(contents.events.naive_cranks.meanAbsError());
  message.naive_charge_mean_abs_error = orNan(contents.events.naive_charges.meanAbsError());
  message.crank_answered_by = nameOf(contents.session.crank_contest);
  message.charge_answered_by = nameOf(contents.session.charge_contest);
  message.answered_crank_mean_abs_error = orNan(contents.events.answered_cranks.meanAbsError());
  message.answered_charge_mean_abs_error = orNan(contents.events.answered_charges.meanAbsError());
}

void append(PredictMap::Response& response, const CrankingAnswer& answer) {
  const Interval u_min = answer.u_min.value_or(kNoInterval);
  response.u_min.push_back(u_min.value);
  response.u_min_lower.push_back(u_min.lower);
  response.u_min_upper.push_back(u_min.upper);
  response.capable.push_back(answer.capable.value_or(false));
  response.u_min_code.push_back(codeOf(answer.code));
}

void append(PredictMap::Response& response, const ChargeAcceptanceAnswer& answer) {
  const Interval i_boost = answer.i_boost.value_or(kNoInterval);
  response.i_boost.push_back(i_boost.value);
  response.i_boost_lower.push_back(i_boost.lower);
  response.i_boost_upper.push_back(i_boost.upper);
  response.i_boost_code.push_back(codeOf(answer.code));
}

CrankingMap crankingMapOf(const LiveModel& model, const PredictMap::Request& request) {
  CrankingQuery query;
  query.i_cranking = request.i_cranking;
  query.t_cranking = orDefault(request.t_cranking, query.t_cranking);
  query.u_required = required(request.u_required);
  return model.mapCranking(query, request.i_load, request.t_stop);
}

ChargeAcceptanceMap chargeMapOf(const LiveModel& model, const PredictMap::Request& request) {
  ChargeAcceptanceQuery query;
  query.i_limit = orDefault(request.i_limit, query.i_limit);
  return model.mapChargeAcceptance(query, request.u_boost, request.t_sof2);
}

void fillEstimates(IdentifiedModel& message, const FittedModel& model) {
  for (const ParameterEstimate& estimate : model.estimates) {
    message.names.push_back(estimate.name);
    message.units.push_back(estimate.unit);
    message.values.push_back(estimate.value);
    message.std.push_back(orNan(estimate.std));
    message.at_bound.push_back(estimate.at_bound);
    message.determined.push_back(estimate.determined);
  }
}

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
  message.family = effect.family;
  message.probability = effect.probability;
  message.evidence = effect.evidence;
  message.voltage_rms = effect.voltage_rms;
  message.absorbed_into = effect.absorbed_into;
  message.tied_with = effect.tied_with;
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
  message.family = candidate.family;
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
  for (ErrorMetrics* metrics : {&none.base_train, &none.base_holdout, &none.extended_train, &none.extended_holdout})
    metrics->q_dyn_percent = metrics->rmse = metrics->max_abs = kNan;
  fillComparison(message, none);
  message.train_from = message.train_to = message.holdout_from = message.holdout_to = kNan;
}

}  // namespace

CrankingQuery queryOf(const PredictCranking::Request& request) {
  CrankingQuery query{request.i_load, request.t_stop, request.i_cranking, request.t_cranking,
                      required(request.u_required)};
  query.load = {request.load_time, request.load_current};
  query.crank = {request.cranking_time, request.cranking_current};
  return query;
}

StopTimeQuery queryOf(const PredictStopTime::Request& request) {
  StopTimeQuery query;
  query.i_load = request.i_load;
  query.i_cranking = request.i_cranking;
  query.t_cranking = orDefault(request.t_cranking, query.t_cranking);
  query.u_required = request.u_required;
  return query;
}

ChargeAcceptanceQuery queryOf(const PredictChargeAcceptance::Request& request) {
  ChargeAcceptanceQuery query;
  query.u_boost = request.u_boost;
  query.t_sof2 = orDefault(request.t_sof2, query.t_sof2);
  query.i_limit = orDefault(request.i_limit, query.i_limit);
  return query;
}

PredictCranking::Response responseOf(const CrankingAnswer& answer) {
  PredictCranking::Response response;
  fillAnswer(response, answer);
  return response;
}

PredictStopTime::Response responseOf(const StopTimeAnswer& answer) {
  PredictStopTime::Response response;
  const Interval t_stop = answer.t_stop.value_or(kNoInterval);
  response.t_stop = t_stop.value;
  response.lower = t_stop.lower;
  response.upper = t_stop.upper;
  if (answer.t_stop) {
    response.outcome = describe(answer.outcome);
    response.monotone = answer.monotone;
  }
  response.valid = answer.valid;
  response.code = codeOf(answer.code);
  response.message = answer.message;
  return response;
}

PredictChargeAcceptance::Response responseOf(const ChargeAcceptanceAnswer& answer) {
  PredictChargeAcceptance::Response response;
  const Interval i_boost = answer.i_boost.value_or(kNoInterval);
  response.i_boost = i_boost.value;
  response.lower = i_boost.lower;
  response.upper = i_boost.upper;
  response.valid = answer.valid;
  response.code = codeOf(answer.code);
  response.message = answer.message;
  return response;
}

PredictMap::Response mapsOf(const LiveModel& model, const PredictMap::Request& request) {
  std::optional<CrankingMap> cranking;
  std::optional<ChargeAcceptanceMap> charge;
  if (!request.i_load.empty() || !request.t_stop.empty()) cranking = crankingMapOf(model, request);
  if (!request.u_boost.empty() || !request.t_sof2.empty()) charge = chargeMapOf(model, request);
  PredictMap::Response response;
  if (cranking)
    for (const CrankingAnswer& answer : cranking->answers) append(response, answer);
  if (charge)
    for (const ChargeAcceptanceAnswer& answer : charge->answers) append(response, answer);
  const MapVerdict verdict = verdictOf(cranking, charge);
  response.valid = verdict.code == AnswerCode::kOk;
  response.code = codeOf(verdict.code);
  response.message = verdict.message;
  return response;
}

SimulateProfile::Response responseOf(const ProfileAnswer& answer) {
  SimulateProfile::Response response;
  response.voltage = answer.predicted.voltage;
  response.lower = answer.predicted.lower;
  response.upper = answer.predicted.upper;
  response.valid = answer.valid;
  response.code = static_cast<std::uint8_t>(answer.code);
  response.message = answer.message;
  return response;
}

IdentifiedModel messageOf(const FittedModel& model) {
  IdentifiedModel message;
  message.header.stamp = rosTime(model.state.time);
  fillEstimates(message, model);
  message.u_c2 = model.state.u_c2;
  message.window_from = model.window.from;
  message.window_to = model.window.to;
  message.window_samples = static_cast<std::uint32_t>(model.window.samples);
  message.status = describe(model.status);
  message.message = model.message;
  message.q_dyn_percent = model.scores.q_dyn_percent;
  message.rmse = model.scores.rmse;
  message.suitability = model.suitability;
  message.fit_ms = model.fit_ms;
  message.effects = model.effects;
  message.model_yaml = modelYaml(model);
  return message;
}

Identify::Response responseOf(const IdentificationOutcome& outcome) {
  Identify::Response response;
  response.accepted = outcome.accepted;
  response.code = outcome.accepted ? Identify::Response::OK : Identify::Response::REFUSED;
  response.message = outcome.message;
  if (outcome.model) response.model = messageOf(*outcome.model);
  return response;
}

DiagnosisMessage messageOf(const DiagnosisReport& report, const Adoption& adoption) {
  const Diagnosis& diagnosis = *report.diagnosis;
  DiagnosisMessage message;
  message.header.stamp = rosTime(report.to);
  message.from = report.from;
  message.samples = static_cast<std::uint32_t>(report.samples);
  message.duration_ms = report.duration_ms;
  message.verdict = describe(diagnosis.verdict);
  message.summary = diagnosis.summary;
  message.family = diagnosis.family ? familyId(*diagnosis.family) : "";
  message.probability = diagnosis.probability;
  message.left_rmse = diagnosis.left.rmse;
  for (const NamedEffect& effect : diagnosis.effects) message.effects.push_back(effectOf(effect));
  for (const Candidate& candidate : diagnosis.candidates)
    message.candidates.push_back(candidateOf(candidate));
  for (const MismatchSegment& segment : diagnosis.mismatch)
    message.mismatch.push_back(segmentOf(segment));
  message.instrument = diagnosis.instrument;
  message.outside = diagnosis.outside;
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

Diagnose::Response responseOf(const DiagnosisOutcome& outcome) {
  Diagnose::Response response;
  response.success = outcome.message.has_value();
  response.code = response.success ? Diagnose::Response::OK : Diagnose::Response::FAILED;
  response.message = response.success ? outcome.message->summary : outcome.fault;
  if (response.success) response.diagnosis = *outcome.message;
  return response;
}

StandingAnswers answersTo(const StandingQueries& standing, const LiveModel& model) {
  StandingAnswers answers;
  answers.cranking = model.predictCranking(standing.cranking);
  if (const auto stop_time = standing.stopTime()) answers.stop_time = model.predictStopTime(*stop_time);
  answers.charge = model.predictChargeAcceptance(standing.charge);
  return answers;
}

SofStatus messageOf(const StatusContents& contents) {
  SofStatus message;
  message.state = stateCode(contents.session.state);
  message.reason = contents.session.reason;
  message.model_age = orNan(contents.session.model_age);
  message.suitability = orNan(contents.session.suitability);
  message.backtest_q_dyn_percent = orNan(contents.session.backtest.q_dyn_percent);
  message.backtest_duration = contents.session.backtest.duration;
  fillContest(message, contents.session);
  fillStandingQuestion(message, contents.standing);
  fillAnswer(message, contents.answers.cranking);
  fillStopTime(message, contents.answers.stop_time);
  fillCharge(message, contents.answers.charge);
  fillCranks(message, contents.events);
  fillCharges(message, contents.events);
  fillSourceAndNaive(message, contents);
  message.accepted = contents.counts.accepted;
  message.rejected = contents.counts.rejectedTotal();
  return message;
}

}  // namespace battery_sof
