#pragma once

#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/BatteryState.h>

#include <mutex>
#include <optional>
#include <string>

#include "battery_sof/predict/online_session.hpp"
#include "battery_sof/ros/identification_worker.hpp"
#include "battery_sof/ros/message_conversion.hpp"
#include "battery_sof/ros/node_diagnostics.hpp"
#include "battery_sof/ros/node_options.hpp"

namespace battery_sof {

/**
 * @brief The ROS face of an OnlineSession: topics, services, state file, diagnostics and log.
 *
 * Threads: samples, queries and timers come in on the global callback queue; ~identify has a queue
 * and a thread of its own, because it waits; identifications run on the worker's thread. `mutex_`
 * guards the session and all that belongs to it; it is never held while a fit runs or a file is
 * written.
 *
 * ~status goes out once a second of the samples' time. A wall timer stands in when no samples come.
 */
class BatterySofNode {
 public:
  /// Starts at once. @param private_node the node's own namespace, for ~status and the services.
  BatterySofNode(ros::NodeHandle node, ros::NodeHandle private_node, NodeOptions options);
  ~BatterySofNode();

 private:
  /// The last crank query that got numbers.
  struct Answered {
    double time = 0.0;  // [s], newest sample when it was asked
    CrankingQuery query;
    Interval u_min;
  };

  void loadStateFile();
  void saveStateFile(const FittedModel& model);
  void advertise();

  void onBatteryState(const sensor_msgs::BatteryStateConstPtr& message);
  void onWallTimer(const ros::WallTimerEvent& event);
  IdentificationOutcome onIdentified(IdentificationResult result);

  bool onPredictCranking(PredictCranking::Request& request, PredictCranking::Response& response);
  bool onSimulateProfile(SimulateProfile::Request& request, SimulateProfile::Response& response);
  bool onIdentify(Identify::Request& request, Identify::Response& response);

  // These want mutex_ held.
  bool isStatusDue() const;
  void publishStatus();
  std::optional<double> noDataFor() const;
  void remember(const CrankingQuery& query, const CrankingAnswer& answer);
  void logCrank(const CrankComparison& crank) const;

  SessionStatus statusNow() const;
  DiagnosticsSnapshot snapshot();
  std::optional<std::future<IdentificationOutcome>> postRequested();

  NodeOptions options_;
  ros::NodeHandle node_, private_node_;
  ros::CallbackQueue identify_queue_;
  ros::Publisher status_publisher_, model_publisher_;

  std::mutex mutex_;
  OnlineSession session_;
  std::optional<double> last_status_time_;  // [s], newest sample at the last ~status
  ros::WallTime last_status_wall_;
  std::optional<ros::Time> last_arrival_;
  std::optional<Answered> last_answer_;
  CrankTally cranks_;
  std::optional<double> fit_ms_;
  std::string state_file_fault_;

  IdentificationWorker worker_;
  NodeDiagnostics diagnostics_;
  ros::Subscriber subscriber_;
  ros::ServiceServer predict_cranking_, simulate_profile_, identify_;
  ros::WallTimer wall_timer_;
  ros::AsyncSpinner identify_spinner_;
};

}  // namespace battery_sof
