#include <ros/ros.h>

#include <chrono>

#include "ros/background_work.hpp"
#include "ros/battery_sof_node.hpp"
#include "ros/message_fields.hpp"

namespace battery_sof {
namespace {

// of a map or a profile: who waits for one gives up about then
constexpr std::chrono::seconds kLongestWork{10};

/// Adds the time it lived to the queries' times.
class QueryTimer {
 public:
  explicit QueryTimer(ResponseClock& clock) : clock_(clock) {}
  QueryTimer(const QueryTimer&) = delete;
  QueryTimer& operator=(const QueryTimer&) = delete;
  ~QueryTimer() { clock_.addQuery(1e3 * (ros::SteadyTime::now() - begun_).toSec()); }

 private:
  ResponseClock& clock_;
  ros::SteadyTime begun_ = ros::SteadyTime::now();
};

}  // namespace

// ----------------------------------------------------------------------------------------------------
// queries

ModelSnapshot BatterySofNode::live() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return session_.live();
}

/// Ends what has become too much, or stands in the way of a shutdown.
WorkWatch BatterySofNode::patience() {
  const auto end = std::chrono::steady_clock::now() + kLongestWork;
  return [end](double) -> std::string {
    if (ros::isShuttingDown()) return "the node shut down";
    if (std::chrono::steady_clock::now() < end) return "";
    return format("%d s were over; ask for less at a time", static_cast<int>(kLongestWork.count()));
  };
}

/// Answers a question; one that fails is answered too, without numbers.
template <typename Answer, typename Response, typename Ask>
bool BatterySofNode::answer(const char* what, Response& response, Ask ask) {
  if (guarded(what, [&] { response = messageAs<Response>(Answer(ask())); })) return true;
  Answer none;
  none.code = AnswerCode::kNoModel;
  none.message = std::string(what) + " failed; /diagnostics says why";
  response = messageAs<Response>(none);
  return true;
}

bool BatterySofNode::onPredictCranking(PredictCranking::Request& request,
                                       PredictCranking::Response& response) {
  const QueryTimer timer(response_clock_);
  return answer<CrankingAnswer>("the crank query", response, [&] {
    const CrankingQuery query = queryOf(request);
    const ModelSnapshot model = live();
    const CrankingAnswer answer = model.predictCranking(query);
    if (answer.u_min) {
      const std::lock_guard<std::mutex> lock(mutex_);
      last_answer_ = Answered{model.model().state.time, query, *answer.u_min};
    }
    ROS_DEBUG("crank query at %.2f s (%s): %s", model.model().state.time,
              toString(answer.code).c_str(), answer.message.c_str());
    return answer;
  });
}

bool BatterySofNode::onPredictStopTime(PredictStopTime::Request& request,
                                       PredictStopTime::Response& response) {
  const QueryTimer timer(response_clock_);
  return answer<StopTimeAnswer>("the stop time query", response,
                                [&] { return live().predictStopTime(queryOf(request)); });
}

bool BatterySofNode::onPredictChargeAcceptance(PredictChargeAcceptance::Request& request,
                                               PredictChargeAcceptance::Response& response) {
  const QueryTimer timer(response_clock_);
  return answer<ChargeAcceptanceAnswer>("the charge query", response, [&] {
    return live().predictChargeAcceptance(queryOf(request));
  });
}

bool BatterySofNode::onSetStandingQuery(SetStandingQuery::Request& request,
                                        SetStandingQuery::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  try {
    options_.standing = changedBy(request, options_.standing);
    response = responseOf(options_.standing, session_.chargeVoltage());
  } catch (const NodeOptionsError& error) {
    response = refusalOf(error, options_.standing, session_.chargeVoltage());
  }
  return true;
}

bool BatterySofNode::onPredictMap(PredictMap::Request& request, PredictMap::Response& response) {
  if (guarded("the map", [&] { response = mapsOf(live(), request, patience()); })) return true;
  response = {};
  response.code = PredictMap::Response::NO_MODEL;
  response.message = "the map failed; /diagnostics says why";
  return true;
}

bool BatterySofNode::onSimulateProfile(SimulateProfile::Request& request,
                                       SimulateProfile::Response& response) {
  return answer<ProfileAnswer>("the profile", response, [&] {
    return live().simulateProfile(request.time, request.current, patience());
  });
}

}  // namespace battery_sof
