#include <cmath>

#include "message_parts.hpp"
#include "ros/message_conversion.hpp"

namespace battery_sof {
namespace {

std::uint8_t stateCode(SessionState state) {
  switch (state) {
    case SessionState::kNoSample: return SofStatus::NO_DATA;
    case SessionState::kCollecting: return SofStatus::COLLECTING;
    case SessionState::kIdentifying: return SofStatus::IDENTIFYING;
    case SessionState::kReady: return SofStatus::READY;
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

void fillSelector(SofStatus& message, const SessionStatus& session) {
  message.effects = session.effects;
  message.extension = session.extension;
  message.contest_duration = session.selector ? session.selector->duration : kNan;
  message.base_rmse = session.selector ? session.selector->base_rmse : kNan;
  message.extended_rmse = session.selector ? session.selector->extended_rmse : kNan;
}

void fillAnswers(SofStatus& message, const StandingAnswers& answers) {
  message.crank = messageAs<CrankAnswer>(answers.cranking);
  message.stop_time = messageAs<StopTimeMessage>(answers.stop_time);
  message.charge = messageAs<ChargeAnswer>(answers.charge);
}

/// What the record of one kind of event says of all of them.
EventRecord recordOf(const EventTally& model, const EventTally& baseline,
                     const EventTally& answered, const IntervalCalibration& scale,
                     const BaselineScore& selector) {
  EventRecord record;
  record.count = static_cast<std::uint32_t>(model.count);
  record.coverage = orNan(model.coverageOf());
  record.mean_abs_error = orNan(model.meanAbsError());
  record.baseline_mean_abs_error = orNan(baseline.meanAbsError());
  record.answered_mean_abs_error = orNan(answered.meanAbsError());
  record.answered_by = selector.baseline_selected ? "baseline" : "model";
  record.interval_factor = scale.factor;
  return record;
}

/// The last event's part of a record.
void fillLast(EventRecord& record, double time, double given, double measured,
              const Interval& expected) {
  record.time = time;
  record.stimulus = given;
  record.measured = measured;
  record.expected = expected.value;
  record.lower = expected.lower;
  record.upper = expected.upper;
}

EventRecord cranksOf(const EventTallies& events, const BaselineScore& selector) {
  EventRecord record = recordOf(events.cranks, events.baseline_cranks, events.answered_cranks,
                                events.crank_calibration, selector);
  record.duration = kNan;
  fillLast(record, kNan, kNan, kNan, kNoInterval);
  if (const auto& last = events.last_crank)
    fillLast(record, last->time, last->current, last->measured_minimum, last->expected_minimum);
  return record;
}

EventRecord chargesOf(const EventTallies& events, const BaselineScore& selector) {
  EventRecord record = recordOf(events.charges, events.baseline_charges, events.answered_charges,
                                events.charge_calibration, selector);
  const auto& last = events.last_charge;
  record.duration = last ? last->duration : kNan;
  fillLast(record, kNan, kNan, kNan, kNoInterval);
  if (last)
    fillLast(record, last->time, last->mean_voltage, last->measured_current,
             last->expected_current);
  return record;
}

void fillSource(SofStatus& message, const SessionStatus& session) {
  message.charger_present = session.charger_present;
  message.charger_share = orNan(session.charger_share);
  message.voltage_controlled = session.voltage_controlled;
  const ExpectedSample expected =
      session.expected.value_or(ExpectedSample{kNan, std::nullopt, std::nullopt});
  message.expected_time = expected.time;
  message.expected_voltage = orNan(expected.voltage);
  message.expected_current = orNan(expected.current);
}

}  // namespace

StandingAnswers answersTo(const StandingQueries& standing, const ModelSnapshot& model) {
  StandingAnswers answers;
  answers.cranking = model.predictCranking(standing.cranking);
  answers.stop_time = model.predictStopTime(standing.stopTime());
  answers.charge = model.predictChargeAcceptance(standing.charge);
  return answers;
}

SofStatus messageOf(const StatusContents& contents) {
  SofStatus message;
  message.state = stateCode(contents.session.state);
  message.reason = contents.session.reason;
  if (contents.session.state == SessionState::kReady)
    message.answer_basis = toString(contents.session.basis);
  message.model_age = orNan(contents.session.model_age);
  message.window_quality = orNan(contents.session.window_quality);
  message.backtest_q_dyn_percent = orNan(contents.session.backtest.q_dyn_percent);
  message.backtest_duration = contents.session.backtest.duration;
  fillSelector(message, contents.session);
  fillStandingQuestion(message, contents.standing);
  fillAnswers(message, contents.answers);
  message.past_cranks = cranksOf(contents.events, contents.session.crank_selector);
  message.past_charges = chargesOf(contents.events, contents.session.charge_selector);
  fillSource(message, contents.session);
  message.accepted = contents.counts.accepted;
  message.rejected = contents.counts.rejectedTotal();
  return message;
}

}  // namespace battery_sof
