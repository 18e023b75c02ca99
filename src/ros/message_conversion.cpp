#include "ros/message_conversion.hpp"

#include <utility>

#include "bag/battery_state_message.hpp"
#include "message_parts.hpp"
#include "report/model_yaml.hpp"

namespace battery_sof {
namespace {

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

CrankingMap crankingMapOf(const ModelSnapshot& model, const PredictMap::Request& request,
                          const WorkWatch& watch) {
  const CrankingQuery query =
      asked(CrankingQuery{0.0, 0.0, request.i_cranking, request.t_cranking, request.u_required});
  return model.mapCranking(query, request.i_load, request.t_stop, watch);
}

ChargeAcceptanceMap chargeMapOf(const ModelSnapshot& model, const PredictMap::Request& request,
                                const WorkWatch& watch) {
  ChargeAcceptanceQuery query;
  query.i_limit = request.i_limit;
  return model.mapChargeAcceptance(asked(query), request.u_boost, request.t_sof2, watch);
}

void fillEstimates(IdentifiedModel& message, const Fit& fit) {
  for (const ParameterEstimate& estimate : fit.estimates) {
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

PredictCranking::Response responseOf(const CrankingAnswer& answer) {
  return messageAs<PredictCranking::Response>(answer);
}
PredictStopTime::Response responseOf(const StopTimeAnswer& answer) {
  return messageAs<PredictStopTime::Response>(answer);
}
PredictChargeAcceptance::Response responseOf(const ChargeAcceptanceAnswer& answer) {
  return messageAs<PredictChargeAcceptance::Response>(answer);
}

PredictMap::Response mapsOf(const ModelSnapshot& model, const PredictMap::Request& request,
                            const WorkWatch& watch) {
  std::optional<CrankingMap> cranking;
  std::optional<ChargeAcceptanceMap> charge;
  if (!request.i_load.empty() || !request.t_stop.empty())
    cranking = crankingMapOf(model, request, watch);
  if (!request.u_boost.empty() || !request.t_sof2.empty())
    charge = chargeMapOf(model, request, watch);
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
  fillEstimates(message, model.fit);
  message.u_c2 = model.state.u_c2;
  message.window_from = model.fit.window.from;
  message.window_to = model.fit.window.to;
  message.window_samples = static_cast<std::uint32_t>(model.fit.window.samples);
  message.status = toString(model.fit.status);
  message.message = model.fit.message;
  message.q_dyn_percent = model.fit.scores.q_dyn_percent;
  message.rmse = model.fit.scores.rmse;
  message.window_quality = model.fit.window_quality;
  message.fit_ms = model.provenance.fit_ms;
  message.effects = model.fit.effects;
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

}  // namespace battery_sof
