#include "ros/message_conversion.hpp"

#include <boost/algorithm/string/replace.hpp>
#include <cmath>
#include <utility>

#include "bag/battery_state_sample.hpp"
#include "report/model_yaml.hpp"

namespace battery_sof {

RawSample rawSampleOf(const sensor_msgs::BatteryState& message) {
  const ros::Time& stamp = message.header.stamp;
  return rawSampleOf(BatteryStateMessage{
      {stamp.sec, stamp.nsec}, message.voltage, message.temperature, message.current});
}

ros::Time rosTime(double time) {
  const Stamp stamp = stampOf(time);
  return {stamp.sec, stamp.nsec};
}

// ---------------------------------------------------------------------------------------------
// questions

CrankingQuery queryOf(const PredictCranking::Request& request) {
  CrankingQuery query{request.i_load, request.t_stop, request.i_cranking, request.t_cranking,
                      request.u_required};
  query.load = {request.load_time, request.load_current};
  query.crank = {request.cranking_time, request.cranking_current};
  return asked(std::move(query));
}

StopTimeQuery queryOf(const PredictStopTime::Request& request) {
  return asked(
      StopTimeQuery{request.i_load, request.i_cranking, request.t_cranking, request.u_required});
}

ChargeAcceptanceQuery queryOf(const PredictChargeAcceptance::Request& request) {
  return asked(ChargeAcceptanceQuery{request.u_boost, request.t_sof2, request.i_limit});
}

MapResult mapsOf(const ModelSnapshot& model, const PredictMap::Request& request,
                 const WorkWatch& watch) {
  MapResult result;
  if (!request.i_load.empty() || !request.t_stop.empty()) {
    const CrankingQuery query =
        asked(CrankingQuery{0.0, 0.0, request.i_cranking, request.t_cranking, request.u_required});
    result.cranking = model.mapCranking(query, request.i_load, request.t_stop, watch);
  }
  if (!request.u_boost.empty() || !request.t_sof2.empty()) {
    ChargeAcceptanceQuery query;
    query.i_limit = request.i_limit;
    result.charge = model.mapChargeAcceptance(asked(query), request.u_boost, request.t_sof2, watch);
  }
  return result;
}

DESCRIBED(CrankingQuery, MEMBERS("", i_load, t_stop, i_cranking, t_cranking, u_required))
DESCRIBED(ChargeAcceptanceQuery, MEMBERS("", u_boost, t_sof2, i_limit))
DESCRIBED(StandingQueries, describe(visit, of.cranking), describe(visit, of.charge))

namespace {

/// Where zero has a meaning.
double eitherOf(double asked, double present) { return std::isnan(asked) ? present : asked; }

}  // namespace

StandingQueries changedBy(const SetStandingQuery::Request& request,
                          const StandingQueries& present) {
  XmlRpc::XmlRpcValue parameters;
  XmlRpc::XmlRpcValue& query = parameters["standing_query"];
  query["i_load_a"] = eitherOf(request.i_load, present.cranking.i_load);
  query["t_stop_s"] = eitherOf(request.t_stop, present.cranking.t_stop);
  query["i_cranking_a"] = askedFor(request.i_cranking).value_or(present.cranking.i_cranking);
  query["t_cranking_s"] = askedFor(request.t_cranking).value_or(present.cranking.t_cranking);
  query["u_required_v"] =
      askedFor(request.u_required).value_or(present.cranking.u_required.value_or(0.0));
  query["u_boost_v"] =
      askedFor(request.u_boost).value_or(present.u_boost_is_given ? present.charge.u_boost : 0.0);
  query["t_sof2_s"] = askedFor(request.t_sof2).value_or(present.charge.t_sof2);
  query["i_limit_a"] = askedFor(request.i_limit).value_or(present.charge.i_limit);
  StandingQueries changed = parseNodeOptions(parameters).standing;
  // that of the row
  if (!changed.u_boost_is_given) changed.charge.u_boost = present.charge.u_boost;
  return changed;
}

SetStandingQuery::Response responseOf(StandingQueries standing, const std::optional<double>& lately,
                                      const std::string& faults) {
  standing.charge = standing.chargeAt(lately);
  auto response = messageAs<SetStandingQuery::Response>(standing);
  response.success = faults.empty();
  response.code =
      response.success ? SetStandingQuery::Response::OK : SetStandingQuery::Response::INVALID_QUERY;
  response.message = response.success ? "these queries are answered from the next status on"
                                      : boost::replace_all_copy(faults, "\n", "; ");
  return response;
}

// ---------------------------------------------------------------------------------------------
// models

IdentifiedModel messageOf(const FittedModel& model) {
  auto message = messageAs<IdentifiedModel>(model);
  message.header.stamp = rosTime(model.state.time);
  for (const ParameterEstimate& estimate : model.fit.estimates) {
    message.names.push_back(estimate.name);
    message.units.push_back(estimate.unit);
    message.values.push_back(estimate.value);
    message.std.push_back(orNan(estimate.std));
    message.at_bound.push_back(estimate.at_bound);
    message.determined.push_back(estimate.determined);
  }
  message.u_c2 = model.state.states[0];
  message.window_from = model.fit.window.from;
  message.window_to = model.fit.window.to;
  message.window_samples = static_cast<std::uint32_t>(model.fit.window.samples);
  message.model_yaml = modelYaml(model);
  return message;
}

IdentifyResult resultOf(const IdentificationOutcome& outcome) {
  IdentifyResult result;
  result.accepted = outcome.accepted;
  result.code = outcome.accepted ? IdentifyResult::OK : IdentifyResult::REFUSED;
  result.message = outcome.message;
  if (outcome.model) result.model = messageOf(*outcome.model);
  return result;
}

// ---------------------------------------------------------------------------------------------
// diagnoses

DESCRIBED(FinishedDiagnosis, visit(FIELD(from_time), of.from), MEMBERS("", samples, duration_ms))

DiagnosisMessage messageOf(const FinishedDiagnosis& report, const Adoption& adoption) {
  const Diagnosis& diagnosis = *report.diagnosis;
  auto message = messageAs<DiagnosisMessage>(diagnosis);
  message.header.stamp = rosTime(report.to);
  put(message, report);
  message.probability = diagnosis.probability;
  for (const MechanismProbability& one : diagnosis.mechanisms) {
    message.mechanism_ids.push_back(mechanismId(one.mechanism));
    message.mechanism_probabilities.push_back(one.probability > 0.0 ? one.probability : kNan);
  }
  message.unexplained_rmse = diagnosis.unexplained.rmse;
  const Comparison& fit = diagnosis.fit;
  message.train_from = fit.train.from;
  message.train_to = fit.train.to;
  message.holdout_from = fit.holdout.from;
  message.holdout_to = fit.holdout.to;
  put(message.base_train, fit.base_train);
  put(message.base_holdout, fit.base_holdout);
  put(message.extended_train, fit.extended_train);
  put(message.extended_holdout, fit.extended_holdout);
  message.adopted = !adoption.effects.empty();
  message.adoption = adoption.sentence;
  return message;
}

DiagnoseResult resultOf(const FinishedDiagnosis& report, const Adoption& adoption) {
  DiagnoseResult result;
  result.success = report.diagnosis.has_value();
  result.code = result.success ? DiagnoseResult::OK : DiagnoseResult::FAILED;
  result.message = result.success ? report.diagnosis->summary : report.fault;
  if (result.success) result.diagnosis = messageOf(report, adoption);
  return result;
}

// ---------------------------------------------------------------------------------------------
// status

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

/// What the record of one kind of event says of all of them.
EventRecord recordOf(const KindTally& kind, const IntervalCalibration& scale) {
  const auto& [model, baseline, last] = kind;
  EventRecord record;
  record.count = static_cast<std::uint32_t>(model.count);
  record.coverage = orNan(model.coverageOf());
  record.mean_abs_error = orNan(model.meanAbsError());
  record.baseline_mean_abs_error = orNan(baseline.meanAbsError());
  record.interval_factor = scale.factor;
  record.time = record.duration = record.measured = kNan;
  record.expected = record.lower = record.upper = kNan;
  if (last) put(record, *last);
  record.stimulus = last ? last->stimulus() : kNan;
  return record;
}

}  // namespace

DESCRIBED(SessionStatus, MEMBERS("", reason, model_age, window_quality, effects),
          MEMBERS("", charger_present, charger_share, voltage_controlled))

SofStatus messageOf(const StatusContents& contents) {
  const SessionStatus& session = contents.session;
  auto message = messageAs<SofStatus>(contents.standing);
  message.state = stateCode(session.state);
  put(message, session);
  if (session.state == SessionState::kReady) message.answer_basis = toString(session.basis);
  message.backtest_q_dyn_percent = orNan(session.backtest.q_dyn_percent);
  message.backtest_duration = session.backtest.duration;
  if (const auto& model = contents.model) {
    put(message.crank, model->predictCranking(contents.standing.cranking));
    put(message.stop_time, model->predictStopTime(contents.standing.stopTime()));
    put(message.charge, model->predictChargeAcceptance(contents.standing.charge));
  }
  const EventTallies& events = contents.events;
  message.past_cranks = recordOf(events.cranks, events.calibrations.cranks);
  message.past_charges = recordOf(events.charges, events.calibrations.charges);
  message.expected_time = session.expected ? session.expected->time : kNan;
  message.expected_voltage = session.expected ? orNan(session.expected->voltage) : kNan;
  message.expected_current = session.expected ? orNan(session.expected->current) : kNan;
  message.accepted = contents.counts.accepted;
  message.rejected = contents.counts.rejectedTotal();
  return message;
}

}  // namespace battery_sof
