#include "ros/standing_query.hpp"

#include <cmath>
#include <limits>

namespace battery_sof {

namespace {

/// Where zero has a meaning.
double eitherOf(double asked, double present) { return std::isnan(asked) ? present : asked; }

std::string inOneLine(std::string text) {
  for (std::size_t n = text.find('\n'); n != std::string::npos; n = text.find('\n', n))
    text.replace(n, 1, "; ");
  return text;
}

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

SetStandingQuery::Response responseOf(const StandingQueries& standing,
                                      const std::optional<double>& lately) {
  SetStandingQuery::Response response;
  response.success = true;
  response.code = SetStandingQuery::Response::OK;
  response.message = "asked with every status from the next one on";
  response.i_load = standing.cranking.i_load;
  response.t_stop = standing.cranking.t_stop;
  response.i_cranking = standing.cranking.i_cranking;
  response.t_cranking = standing.cranking.t_cranking;
  response.u_required =
      standing.cranking.u_required.value_or(std::numeric_limits<double>::quiet_NaN());
  response.u_boost = standing.chargeAt(lately).u_boost;
  response.t_sof2 = standing.charge.t_sof2;
  response.i_limit = standing.charge.i_limit;
  return response;
}

SetStandingQuery::Response refusalOf(const NodeOptionsError& error, const StandingQueries& present,
                                     const std::optional<double>& lately) {
  SetStandingQuery::Response response = responseOf(present, lately);
  response.success = false;
  response.code = SetStandingQuery::Response::INVALID_QUERY;
  response.message = inOneLine(error.what());
  return response;
}

}  // namespace battery_sof
