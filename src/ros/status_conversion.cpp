#include <cmath>

#include "battery_sof/ros/message_conversion.hpp"
#include "message_parts.hpp"

namespace battery_sof {
namespace {

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
  const CrankComparison shown = events.last_crank.value_or(CrankComparison{kNan, kNan, kNan, kNoInterval, kNan, {}, false});
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
  const ChargeComparison shown = events.last_charge.value_or(ChargeComparison{kNan, kNan, kNan, kNan, kNan, kNoInterval, kNan, {}, false});
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

}  // namespace

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
