#pragma once

#include <actionlib/server/action_server.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/BatteryState.h>
#include <std_srvs/Trigger.h>

#include <functional>
#include <mutex>
#include <optional>
#include <vector>

#include "prediction/online_session.hpp"
#include "ros/background_work.hpp"
#include "ros/battery_identity.hpp"
#include "ros/change_watch.hpp"
#include "ros/diagnosis_runner.hpp"
#include "ros/message_conversion.hpp"
#include "ros/node_diagnostics.hpp"
#include "ros/node_options.hpp"
#include "ros/node_statistics.hpp"
#include "ros/state_file.hpp"

namespace battery_sof {

/**
 * @brief actionlib's server, which no stamp can end.
 *
 * It keeps an ended goal in its status list for a timeout after the ROS time of its end, or after
 * the stamp of a cancel request for a goal that it does not know; the sum of a late stamp and the
 * timeout is beyond ros::Time and throws. Here the timeout is 0: the list holds an ended goal once.
 */
template <typename Action>
class GoalServer : public actionlib::ActionServer<Action> {
 public:
  using Goal = actionlib::ServerGoalHandle<Action>;

  GoalServer(const ros::NodeHandle& node, const std::string& name,
             const boost::function<void(Goal)>& on_goal,
             const boost::function<void(Goal)>& on_cancel)
      : actionlib::ActionServer<Action>(node, name, on_goal, on_cancel, false),
        results_(ros::NodeHandle(node, name).advertise<ActionResult>("result", kResultsKept)) {}

  /// Takes goals from now on.
  void begin() {
    this->start();
    this->status_list_timeout_ = ros::Duration(0.0);
  }

 private:
  using ActionResult = typename Action::_action_result_type;
  using Result = typename ActionResult::_result_type;
  using actionlib::ActionServerBase<Action>::publishStatus;

  static constexpr std::uint32_t kResultsKept = 50;  // as actionlib's server

  /// As actionlib's server, which ends a goal whose cancel request came first with an empty result:
  /// its code would be the first one, OK.
  void publishResult(const actionlib_msgs::GoalStatus& status, const Result& result) override {
    const boost::recursive_mutex::scoped_lock lock(this->lock_);
    ActionResult message;
    message.header.stamp = ros::Time::now();
    message.status = status;
    message.result = result;
    if (status.status == actionlib_msgs::GoalStatus::RECALLED) {
      message.result.code = Result::RECALLED;
      message.result.message = "the goal was cancelled before work on it began";
    }
    results_.publish(message);
    publishStatus();
  }

  ros::Publisher results_;
};

/**
 * @brief The ROS face of an OnlineSession: topics, services, actions, state file, diagnostics and
 * log.
 *
 * Threads, so that nothing waits for what takes longer:
 *   - samples: the global callback queue, nothing else;
 *   - questions: the three predictions, ~set_standing_query, ~status and /diagnostics, one after the other;
 *   - maps, profiles: one each for ~predict_map and ~simulate_profile, up to kLongestWork;
 *   - goals: the actions ~identify and ~diagnose, which begin and cancel work, and ~set_reference;
 *   - identifications and diagnoses themselves, which end their goals, and comparisons with the
 *     reference: a worker's each;
 *   - the state file: a worker's, but for the last time, at the node's end.
 * `mutex_` guards the session and all that belongs to it. It is held to take a sample in, and to
 * copy what a question needs (OnlineSession::live()); never while a question is computed, a fit
 * runs or a file is written. A worker takes it for a fault's note alone (noteFault()).
 *
 * No exception ends the node: where a callback or a timer throws, the fault is logged and reported
 * in /diagnostics; where taking a sample does, the session begins again, and the saved model it
 * stood on is set aside.
 *
 * At a shutdown a map and a profile break off at once: roscpp ends no service before its callback
 * has returned.
 *
 * The state file is written after each accepted identification, 10 s after an event, once a minute
 * while samples come, and at the node's end: what a process that is killed loses is of a minute.
 *
 * ~status goes out once a second of the samples' time. A timer that no clock's jump touches stands
 * in when no samples come.
 */
class BatterySofNode {
 public:
  /// Starts at once. @param private_node the node's own namespace.
  BatterySofNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                 NodeOptions options);
  ~BatterySofNode();

 private:
  using SampleEvent = ros::MessageEvent<const sensor_msgs::BatteryState>;
  using IdentifyServer = GoalServer<IdentifyAction>;
  using DiagnoseServer = GoalServer<DiagnoseAction>;
  using IdentifyGoals = std::vector<IdentifyServer::GoalHandle>;

  /// A callback queue and the thread that calls it.
  struct QueueThread {
    ros::CallbackQueue queue;
    ros::AsyncSpinner spinner{1, &queue};

    /// @return a node's handle whose callbacks come on this thread.
    ros::NodeHandle handleOf(ros::NodeHandle node) {
      node.setCallbackQueue(&queue);
      return node;
    }
  };

  /// What came since the state file was written.
  struct Unsaved {
    bool samples = false, events = false;
    ros::SteadyTime since = ros::SteadyTime::now();  // when it was written last
  };

  /// The last crank query that got numbers.
  struct Answered {
    double time = 0.0;  // [s], newest sample when it was asked
    CrankingQuery query;
    Interval u_min;
  };

  void loadStateFile();
  void saveStateFile(const FittedModel& model);
  /// Hands the present model over to be saved. @param at_once else only where it is due.
  void save(bool at_once);
  void advertise();
  void advertiseQuestions();
  template <typename Service, typename Ask>
  void serve(const char* name, QueueThread& thread, const char* what, Ask ask);

  void onBatteryState(const SampleEvent& event);
  void onSteadyTimer(const ros::SteadyTimerEvent& event);
  /// @param request of which request_; 0: due by itself.
  void onIdentification(const IdentificationJob& job, int request);
  IdentificationOutcome identified(const IdentificationJob& job, bool is_requested);
  /// Does work with mutex_ held on the questions' thread and waits for it: a worker that gives way
  /// to other programs while it holds the mutex keeps the samples waiting for as long as they run.
  /// What the work throws is thrown here.
  void onQueryThread(const std::function<void()>& work);

  CrankingAnswer answered(const PredictCranking::Request& request);
  bool onSetStandingQuery(SetStandingQuery::Request& request, SetStandingQuery::Response& response);
  void onIdentifyGoal(const IdentifyServer::GoalHandle& goal);
  void onIdentifyCancel(IdentifyServer::GoalHandle goal);
  void beginRequested();
  void endRequested(int request, const IdentifyResult& result);
  void onDiagnoseGoal(DiagnoseServer::GoalHandle goal);
  bool onSetReference(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  // These need mutex_ held.
  IdentificationOutcome takenBack(IdentificationResult result, bool is_requested);
  void take(const sensor_msgs::BatteryState& message);
  void push(const RawSample& sample);
  /// Forgets the battery before, its saved model too.
  void beginOtherBattery();
  std::optional<FittedModel> modelToSave() const;
  void beginAnew(const char* why);
  bool isStatusDue() const;
  void demandStatus();
  std::optional<double> noDataFor() const;
  void logCrank(const EventComparison& crank) const;
  SessionStatus statusNow() const;

  /// Does the work; an exception becomes a fault. @return true when there was none.
  template <typename Work>
  bool guarded(const char* what, Work work) {
    try {
      work();
      return true;
    } catch (const std::exception& error) {
      noteFault(what, error.what());
    }
    return false;
  }
  void noteFault(const char* what, const char* why);
  ModelSnapshot live();
  void publishDueStatus();
  DiagnosticsSnapshot snapshot();

  NodeOptions options_;
  const StateFile state_file_;
  ros::NodeHandle node_, private_node_;
  QueueThread questions_, maps_, profiles_, actions_;
  ros::Publisher status_publisher_, model_publisher_;

  std::mutex mutex_;
  OnlineSession session_;
  std::optional<double> last_status_time_;  // [s], newest sample at the last ~status
  ros::SteadyTime last_status_steady_, last_diagnostics_steady_;
  std::optional<StatusContents> due_status_;  // whose answers are still to be computed
  std::optional<ros::Time> last_arrival_;
  std::optional<Answered> last_answer_;
  NodeRecord record_;
  BatteryIdentity battery_;
  bool stands_on_state_file_ = false;
  Unsaved unsaved_;
  bool is_request_wanted_ = false;  // the requested identification that runs has a goal

  // Of the goals' thread alone. A goal waits, runs, or has ended.
  IdentifyGoals waiting_goals_, running_goals_;
  int request_ = 0;  // the last identification that goals began

  ResponseClock response_clock_;
  BackgroundWorker worker_;
  BackgroundWorker saver_;  // of the state file, one writer at a time
  DiagnosisRunner diagnoses_;
  ChangeWatch changes_;
  NodeDiagnostics diagnostics_;
  ros::Subscriber subscriber_;
  std::vector<ros::ServiceServer> services_;
  IdentifyServer identify_server_;
  DiagnoseServer diagnose_server_;
  ros::SteadyTimer steady_timer_;
};

}  // namespace battery_sof
