#include <ros/ros.h>

#include <chrono>

#include "ros/background_work.hpp"
#include "ros/battery_sof_node.hpp"

namespace battery_sof {
namespace {

// of a map or a profile: who waits for one gives up about then
constexpr std::chrono::seconds kLongestWork{10};
constexpr std::chrono::milliseconds kLook{50};

/// The outcome of background work. @throws std::future_error when the node ends first.
template <typename Outcome>
Outcome waitFor(std::future<Outcome>& work) {
  while (work.wait_for(kLook) != std::future_status::ready)
    if (ros::isShuttingDown()) throw std::future_error(std::future_errc::broken_promise);
  return work.get();
}

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
  if (guarded(what, [&] { response = responseOf(ask()); })) return true;
  Answer none;
  none.code = AnswerCode::kNoModel;
  none.message = std::string(what) + " failed; /diagnostics says why";
  response = responseOf(none);
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

// ----------------------------------------------------------------------------------------------------
// identification

IdentificationOutcome BatterySofNode::onIdentified(const IdentificationJob& job) {
  IdentificationOutcome outcome;
  outcome.message = "the identification failed; /diagnostics says why";
  guarded("the identification", [&] { outcome = identified(job); });
  return outcome;
}

IdentificationOutcome BatterySofNode::identified(const IdentificationJob& job) {
  const IdentificationOutcome outcome = takeBack(timedIdentification(job));
  ROS_INFO("identification %s: %s", outcome.accepted ? "accepted" : "refused",
           outcome.message.c_str());
  if (outcome.accepted) {
    model_publisher_.publish(messageOf(*outcome.model));
    saveStateFile(*outcome.model);
  }
  if (outcome.extended) model_publisher_.publish(messageOf(*outcome.extended));
  return outcome;
}

IdentificationOutcome BatterySofNode::takeBack(IdentificationResult result) {
  IdentificationOutcome outcome;
  ahead([&] { outcome = takenBack(std::move(result)); });
  return outcome;
}

IdentificationOutcome BatterySofNode::takenBack(IdentificationResult result) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (result.model) {
    result.model->provenance.recording = subscriber_.getTopic();
    fit_ms_ = result.model->provenance.fit_ms;
  }
  if (result.extended && result.extended->model)
    result.extended->model->provenance.recording = subscriber_.getTopic();
  IdentificationOutcome outcome = session_.finish(std::move(result));
  announceWhoAnswers();
  demandStatus();
  return outcome;
}

std::optional<std::future<IdentificationOutcome>> BatterySofNode::postRequested() {
  while (!ros::isShuttingDown()) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (auto job = session_.takeJob()) return worker_.post(std::move(*job));
      if (!session_.isJobOut()) return std::nullopt;
    }
    worker_.waitUntilIdle(kLook);
  }
  return std::nullopt;
}

bool BatterySofNode::onIdentify(Identify::Request&, Identify::Response& response) {
  response.code = Identify::Response::REFUSED;
  response.message = "the identification failed; /diagnostics says why";
  guarded("the identification", [&] { identifyNow(response); });
  return true;
}

void BatterySofNode::identifyNow(Identify::Response& response) {
  auto outcome = postRequested();
  if (!outcome) {
    response.code = Identify::Response::NO_DATA;
    response.message = "no samples are buffered yet";
    return;
  }
  try {
    response = responseOf(waitFor(*outcome));
  } catch (const std::future_error&) {
    response.code = Identify::Response::REFUSED;
    response.message = "the node is shutting down";
  }
}

// ----------------------------------------------------------------------------------------------------
// diagnosis

void BatterySofNode::onAdopted(const Adoption& adoption, double from_driving) {
  ahead([&] {
    const std::lock_guard<std::mutex> lock(mutex_);
    session_.extendWith(adoption.effects, from_driving, adoption.discrepancy);
  });
}

std::optional<std::future<DiagnosisRunner::Outcome>> BatterySofNode::beginDiagnosis(
    Diagnose::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (session_.series().empty()) {
    response.code = Diagnose::Response::NO_DATA;
    response.message = "no samples are buffered yet";
    return std::nullopt;
  }
  auto running = diagnoses_.begin(session_.series(), subscriber_.getTopic());
  if (running) return running;
  response.code = Diagnose::Response::BUSY;
  response.message = "a diagnosis is running; its result will be on ~diagnosis";
  return std::nullopt;
}

bool BatterySofNode::onDiagnose(Diagnose::Request&, Diagnose::Response& response) {
  response.code = Diagnose::Response::FAILED;
  response.message = "the diagnosis failed; /diagnostics says why";
  guarded("the diagnosis", [&] { diagnoseNow(response); });
  return true;
}

bool BatterySofNode::onCancelDiagnosis(CancelDiagnosis::Request&,
                                       CancelDiagnosis::Response& response) {
  const auto said = diagnoses_.cancel();
  response.cancelled = said.has_value();
  response.message = said.value_or("no diagnosis runs");
  return true;
}

void BatterySofNode::diagnoseNow(Diagnose::Response& response) {
  auto running = beginDiagnosis(response);
  if (!running) return;
  try {
    response = responseOf(waitFor(*running));
  } catch (const std::future_error&) {
    response.code = Diagnose::Response::FAILED;
    response.message = "the node is shutting down";
  }
}

}  // namespace battery_sof
