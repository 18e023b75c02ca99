#include <ros/ros.h>

#include <algorithm>
#include <utility>

#include "ros/background_work.hpp"
#include "ros/battery_sof_node.hpp"

namespace battery_sof {

// ----------------------------------------------------------------------------------------------------
// identification

void BatterySofNode::onIdentification(const Identification& work) {
  IdentifyResult result;
  result.code = IdentifyResult::REFUSED;
  result.message = "the identification failed; /diagnostics says why";
  guarded("the identification", [&] { result = resultOf(identified(work)); });
  callFrom(action_queue_, [this, result, request = work.request] {
    guarded("the identification", [&] { endRequested(request, result); });
  });
}

IdentificationOutcome BatterySofNode::identified(const Identification& work) {
  IdentificationResult result = timedIdentification(work.job);
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

void BatterySofNode::onAdopted(const Adoption& adoption, double from_driving) {
  ahead([&] {
    const std::lock_guard<std::mutex> lock(mutex_);
    session_.extendWith(adoption.effects, from_driving, adoption.discrepancy);
  });
}

void BatterySofNode::onDiagnoseGoal(DiagnoseServer::GoalHandle goal) {
  DiagnoseResult refusal;
  refusal.code = DiagnoseResult::FAILED;
  refusal.message = "the diagnosis failed; /diagnostics says why";
  bool begins = false;
  guarded("the diagnosis", [&] { begins = beginDiagnosis(goal, refusal); });
  if (!begins) goal.setRejected(refusal, refusal.message);
}

bool BatterySofNode::beginDiagnosis(const DiagnoseServer::GoalHandle& goal,
                                    DiagnoseResult& refusal) {
  Series series;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    series = session_.series();
  }
  if (series.empty()) {
    refusal.code = DiagnoseResult::NO_DATA;
    refusal.message = "no samples are buffered yet";
    return false;
  }
  if (diagnoses_.begin(series, subscriber_.getTopic(), goal)) return true;
  refusal.code = DiagnoseResult::BUSY;
  refusal.message = "a diagnosis is running; its result will be on ~diagnosis";
  return false;
}

}  // namespace battery_sof
