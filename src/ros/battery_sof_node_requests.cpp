#include <ros/ros.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "ros/background_work.hpp"
#include "ros/battery_sof_node.hpp"
#include "ros/message_conversion.hpp"

/// What others ask of the node: services and actions.
namespace battery_sof {
namespace {

// of a map or a profile: who waits for one gives up about then
constexpr std::chrono::seconds kLongestWork{10};

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

/// Answers a question; one that fails is answered too, without numbers. The time that a profile
/// takes is none of a query's.
template <typename Answer, typename Response, typename Ask>
bool BatterySofNode::answer(const char* what, Response& response, Ask ask) {
  const ros::SteadyTime begun = ros::SteadyTime::now();
  const bool is_answered = guarded(what, [&] { response = messageAs<Response>(Answer(ask())); });
  if (!std::is_same_v<Answer, ProfileAnswer>)
    response_clock_.addQuery(1e3 * (ros::SteadyTime::now() - begun).toSec());
  if (is_answered) return true;
  Answer none;
  none.code = AnswerCode::kNoModel;
  none.message = std::string(what) + " failed; /diagnostics says why";
  response = messageAs<Response>(none);
  return true;
}

bool BatterySofNode::onPredictCranking(PredictCranking::Request& request,
                                       PredictCranking::Response& response) {
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
  return answer<StopTimeAnswer>("the stop time query", response,
                                [&] { return live().predictStopTime(queryOf(request)); });
}

bool BatterySofNode::onPredictChargeAcceptance(PredictChargeAcceptance::Request& request,
                                               PredictChargeAcceptance::Response& response) {
  return answer<ChargeAcceptanceAnswer>("the charge query", response, [&] {
    return live().predictChargeAcceptance(queryOf(request));
  });
}

bool BatterySofNode::onSetStandingQuery(SetStandingQuery::Request& request,
                                        SetStandingQuery::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string faults;
  try {
    options_.standing = changedBy(request, options_.standing);
  } catch (const NodeOptionsError& error) {
    faults = error.what();
  }
  response = responseOf(options_.standing, session_.chargeVoltage(), faults);
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

void BatterySofNode::onIdentification(const Identification& work) {
  IdentifyResult result;
  result.code = IdentifyResult::REFUSED;
  result.message = "the identification failed; /diagnostics says why";
  guarded("the identification", [&] { result = resultOf(identified(work)); });
  callFrom(actions_.queue, [this, result, request = work.request] {
    guarded("the identification", [&] { endRequested(request, result); });
  });
}

IdentificationOutcome BatterySofNode::identified(const Identification& work) {
  const ros::SteadyTime begun = ros::SteadyTime::now();
  IdentificationResult result;
  try {
    result = runIdentification(work.job);
  } catch (const std::exception& error) {
    result.epoch = work.job.epoch;
    result.message = std::string("the identification failed: ") + error.what();
  }
  const double fit_ms = 1e3 * (ros::SteadyTime::now() - begun).toSec();
  if (result.model) result.model->provenance.fit_ms = fit_ms;
  if (result.extended && result.extended->model) result.extended->model->provenance.fit_ms = fit_ms;
  IdentificationOutcome outcome;
  ahead([&] { outcome = takenBack(std::move(result), work.request != 0); });
  ROS_INFO("identification %s: %s", outcome.accepted ? "accepted" : "refused",
           outcome.message.c_str());
  if (outcome.accepted) {
    model_publisher_.publish(messageOf(*outcome.model));
    saveStateFile(*outcome.model);
  }
  if (outcome.extended) model_publisher_.publish(messageOf(*outcome.extended));
  return outcome;
}

IdentificationOutcome BatterySofNode::takenBack(IdentificationResult result, bool is_requested) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (is_requested && !std::exchange(is_request_wanted_, false)) {
    result.model.reset();
    result.extended.reset();
    result.message = "the goal was cancelled";
  }
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

void BatterySofNode::onIdentifyGoal(const IdentifyServer::GoalHandle& goal) {
  waiting_goals_.push_back(goal);
  guarded("the identification", [this] { beginRequested(); });
}

/// Begins an identification for the goals that wait, unless one runs: its end calls this again.
void BatterySofNode::beginRequested() {
  if (waiting_goals_.empty()) return;
  std::optional<IdentificationJob> job;
  bool is_busy = !running_goals_.empty();
  if (!is_busy) {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_busy = session_.isJobOut();
    job = session_.takeJob();
    if (job) is_request_wanted_ = true;
  }
  if (is_busy) {
    waiting_goals_.back().publishFeedback(
        feedbackOf<IdentifyFeedback>("waiting for the identification that runs"));
    return;
  }
  IdentifyGoals goals = std::exchange(waiting_goals_, {});
  if (!job) {
    IdentifyResult none;
    none.code = IdentifyResult::NO_DATA;
    none.message = "no samples are buffered yet";
    for (auto& goal : goals) goal.setRejected(none, none.message);
    return;
  }
  for (auto& goal : goals) {
    goal.setAccepted();
    goal.publishFeedback(feedbackOf<IdentifyFeedback>("fitting"));
  }
  running_goals_ = std::move(goals);
  worker_.post({std::move(*job), ++request_});
}

void BatterySofNode::endRequested(int request, const IdentifyResult& result) {
  if (request == request_) {
    for (auto& goal : std::exchange(running_goals_, {})) {
      if (result.accepted) {
        goal.setSucceeded(result, result.message);
      } else {
        goal.setAborted(result, result.message);
      }
    }
  }
  beginRequested();
}

void BatterySofNode::onIdentifyCancel(IdentifyServer::GoalHandle goal) {
  const bool is_last = running_goals_ == IdentifyGoals{goal};
  if (is_last) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!std::exchange(is_request_wanted_, false)) return;  // it has ended; its result comes
  }
  for (IdentifyGoals* goals : {&waiting_goals_, &running_goals_})
    goals->erase(std::remove(goals->begin(), goals->end(), goal), goals->end());
  IdentifyResult result;
  result.code = IdentifyResult::REFUSED;
  result.message = is_last
                       ? "cancelled; the fit that runs is not broken off, its result is discarded"
                       : "cancelled";
  goal.setCanceled(result, result.message);
}

// ----------------------------------------------------------------------------------------------------
// diagnosis

void BatterySofNode::onDiagnoseGoal(DiagnoseServer::GoalHandle goal) {
  DiagnoseResult refusal;
  const auto refuse = [&refusal](std::uint8_t code, const char* message) {
    refusal.code = code;
    refusal.message = message;
  };
  refuse(DiagnoseResult::FAILED, "the diagnosis failed; /diagnostics says why");
  bool begins = false;
  guarded("the diagnosis", [&] {
    Series series;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      series = session_.series();
    }
    if (series.empty()) return refuse(DiagnoseResult::NO_DATA, "no samples are buffered yet");
    begins = diagnoses_.begin(series, subscriber_.getTopic(), goal);
    if (!begins)
      refuse(DiagnoseResult::BUSY, "a diagnosis is running; its result will be on ~diagnosis");
  });
  if (!begins) goal.setRejected(refusal, refusal.message);
}

}  // namespace battery_sof
