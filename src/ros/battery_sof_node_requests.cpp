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

/// Ends what has become too much, or stands in the way of a shutdown.
WorkWatch patience() {
  const auto end = std::chrono::steady_clock::now() + kLongestWork;
  return [end](double) -> std::string {
    if (ros::isShuttingDown()) return "the node is shutting down";
    if (std::chrono::steady_clock::now() < end) return "";
    return format("it took more than %d s; ask for less at a time",
                  static_cast<int>(kLongestWork.count()));
  };
}

}  // namespace

// ----------------------------------------------------------------------------------------------------
// queries

ModelSnapshot BatterySofNode::live() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return session_.live();
}

/// Advertises a service whose response is the answer that `ask` gives to a request. A question that
/// fails is answered too, without numbers. The time that a map or a profile takes is none of a
/// query's.
template <typename Service, typename Ask>
void BatterySofNode::serve(const char* name, QueueThread& thread, const char* what, Ask ask) {
  using Request = typename Service::Request;
  using Response = typename Service::Response;
  const boost::function<bool(Request&, Response&)> answer = [=, &thread](Request& request,
                                                                         Response& response) {
    const ros::SteadyTime begun = ros::SteadyTime::now();
    const bool is_answered = guarded(what, [&] { response = messageAs<Response>(ask(request)); });
    if (&thread == &questions_)
      response_clock_.addQuery(1e3 * (ros::SteadyTime::now() - begun).toSec());
    if (is_answered) return true;
    response = messageAs<Response>(decltype(ask(request))());
    response.code = Response::NO_MODEL;
    response.message = std::string(what) + " failed; /diagnostics says why";
    return true;
  };
  services_.push_back(thread.handleOf(private_node_).advertiseService(name, answer));
}

void BatterySofNode::advertiseQuestions() {
  serve<PredictCranking>("predict_cranking", questions_, "the crank query",
                         [this](const auto& request) { return answered(request); });
  serve<PredictStopTime>(
      "predict_stop_time", questions_, "the stop time query",
      [this](const auto& request) { return live().predictStopTime(queryOf(request)); });
  serve<PredictChargeAcceptance>(
      "predict_charge_acceptance", questions_, "the charge query",
      [this](const auto& request) { return live().predictChargeAcceptance(queryOf(request)); });
  serve<PredictMap>("predict_map", maps_, "the map",
                    [this](const auto& request) { return mapsOf(live(), request, patience()); });
  serve<SimulateProfile>("simulate_profile", profiles_, "the profile", [this](const auto& request) {
    return live().simulateProfile(request.time, request.current, patience());
  });
  services_.push_back(
      questions_.handleOf(private_node_)
          .advertiseService("set_standing_query", &BatterySofNode::onSetStandingQuery, this));
  services_.push_back(
      actions_.handleOf(private_node_)
          .advertiseService("set_reference", &BatterySofNode::onSetReference, this));
}

CrankingAnswer BatterySofNode::answered(const PredictCranking::Request& request) {
  const CrankingQuery query = queryOf(request);
  const ModelSnapshot model = live();
  const CrankingAnswer answer = model.predictCranking(query);
  if (answer.u_min) {
    const std::lock_guard<std::mutex> lock(mutex_);
    last_answer_ = Answered{model.model()->state.time, query, *answer.u_min};
  }
  ROS_DEBUG("crank query at %.2f s (%s): %s", model.model() ? model.model()->state.time : NAN,
            toString(answer.code).c_str(), answer.message.c_str());
  return answer;
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

// ----------------------------------------------------------------------------------------------------
// identification

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
        feedbackOf<IdentifyFeedback>("waiting for the running identification"));
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
  worker_.post(
      [this, job = std::move(*job), request = ++request_] { onIdentification(job, request); });
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
  result.message =
      is_last ? "cancelled; the running fit continues, but its result is discarded" : "cancelled";
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

// ----------------------------------------------------------------------------------------------------
// changes

bool BatterySofNode::onSetReference(std_srvs::Trigger::Request&,
                                    std_srvs::Trigger::Response& response) {
  response.message = "setting the reference failed; /diagnostics says why";
  guarded("setting the reference", [&] {
    Series series;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      series = session_.series();
    }
    const ChangeWatch::Outcome outcome = changes_.setReference(series, subscriber_.getTopic());
    response.success = outcome.success;
    response.message = outcome.message;
  });
  if (response.success) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      unsaved_.samples = true;
    }
    save(true);
  }
  return true;
}

}  // namespace battery_sof
