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

/// The fields that a service's response and the standing answer of the status share.
template <typename Message>
void fillAnswer(Message& message, const CrankingAnswer& answer) {
  const Interval u_min = answer.u_min.value_or(kNoInterval);
  message.u_min = u_min.value;
  message.lower = u_min.lower;
  message.upper = u_min.upper;
  message.capable = answer.capable.value_or(false);
  message.valid = answer.valid;
  message.code = static_cast<std::uint8_t>(answer.code);
  message.message = answer.message;
}

void fillStandingQuestion(SofStatus& message, const CrankingQuery& query) {
  message.i_load = query.i_load;
  message.t_stop = query.t_stop;
  message.i_cranking = query.i_cranking;
  message.t_cranking = query.t_cranking;
  message.u_required = orNan(query.u_required);
}

void fillLastCrank(SofStatus& message, const std::optional<CrankComparison>& crank) {
  const CrankComparison shown =
      crank.value_or(CrankComparison{kNan, kNan, kNan, {kNan, kNan, kNan}});
  message.crank_time = shown.time;
  message.crank_current = shown.current;
  message.crank_measured = shown.measured_minimum;
  message.crank_expected = shown.expected_minimum.value;
  message.crank_lower = shown.expected_minimum.lower;
  message.crank_upper = shown.expected_minimum.upper;
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

}  // namespace

CrankingQuery queryOf(const PredictCranking::Request& request) {
  CrankingQuery query{request.i_load, request.t_stop, request.i_cranking, request.t_cranking, {}};
  if (!std::isnan(request.u_required)) query.u_required = request.u_required;
  return query;
}

PredictCranking::Response responseOf(const CrankingAnswer& answer) {
  PredictCranking::Response response;
  fillAnswer(response, answer);
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

SofStatus messageOf(const StatusContents& contents) {
  SofStatus message;
  message.state = stateCode(contents.session.state);
  message.reason = contents.session.reason;
  message.model_age = orNan(contents.session.model_age);
  message.suitability = orNan(contents.session.suitability);
  message.backtest_q_dyn_percent = orNan(contents.session.backtest.q_dyn_percent);
  message.backtest_duration = contents.session.backtest.duration;
  fillStandingQuestion(message, contents.standing_query);
  fillAnswer(message, contents.standing_answer);
  fillLastCrank(message, contents.last_crank);
  message.cranks = static_cast<std::uint32_t>(contents.cranks);
  message.accepted = contents.counts.accepted;
  message.rejected = contents.counts.rejectedTotal();
  return message;
}

}  // namespace battery_sof
