#include <battery_sof/PredictChargeAcceptance.h>
#include <battery_sof/PredictCranking.h>
#include <battery_sof/PredictStopTime.h>
#include <battery_sof/SofStatus.h>
#include <ros/ros.h>
#include <sensor_msgs/BatteryState.h>
#include <std_msgs/Bool.h>

#include <mutex>
#include <thread>

#include "energy_manager/Decision.h"
#include "energy_manager/decision.hpp"

namespace energy_manager {
namespace {

/// A parameter that has to be a number in a range. @throws std::runtime_error naming it, its value
/// and the range.
double parameter(const ros::NodeHandle& own, const std::string& name, double value, double low,
                 double high) {
  XmlRpc::XmlRpcValue given;
  const bool is_given = own.getParam(name, given);
  if (is_given && !own.getParam(name, value))
    throw std::runtime_error(own.resolveName(name) + " is not a number");
  if (!(value >= low && value <= high)) {
    throw std::runtime_error(own.resolveName(name) + " is " + std::to_string(value) +
                             ", expected " + std::to_string(low) + " to " + std::to_string(high));
  }
  return value;
}

Rule readRule(const ros::NodeHandle& own) {
  Rule rule;
  rule.u_required = parameter(own, "u_required_v", rule.u_required, 1.0, 100.0);
  rule.margin = parameter(own, "margin_v", rule.margin, 0.0, 10.0);
  rule.look_ahead = parameter(own, "look_ahead_s", rule.look_ahead, 0.1, 600.0);
  rule.i_load = parameter(own, "i_load_a", rule.i_load, -500.0, 0.0);
  rule.i_cranking = parameter(own, "i_cranking_a", rule.i_cranking, -2000.0, -1.0);
  rule.t_cranking = parameter(own, "t_cranking_s", rule.t_cranking, 0.01, 60.0);
  rule.u_boost = parameter(own, "u_boost_v", rule.u_boost, 1.0, 100.0);
  rule.i_limit = parameter(own, "i_limit_a", rule.i_limit, 1.0, 5000.0);
  rule.t_boost = parameter(own, "t_boost_s", rule.t_boost, 0.1, 3600.0);
  return rule;
}

/// Numbers and validity of a service's response, whichever of the three it is.
template <typename Response>
Answer answerOf(const Response& response) {
  return {response.valid && response.code == Response::OK, response.lower, response.message};
}

/**
 * Asks battery_sof in a thread of its own, and decides in another: a service that does not come
 * back delays no decision. How old status and answers are is measured by the computer's clock, as a
 * node that hangs stops no clock of the car.
 */
class EnergyManager {
 public:
  EnergyManager(ros::NodeHandle node, ros::NodeHandle own)
      : rule_(readRule(own)),
        habits_(rule_),
        max_age_(parameter(own, "answer_max_age_s", 1.0, 0.05, 60.0)),
        battery_(own.param<std::string>("battery_node", "battery_sof_node")) {
    decisions_ = own.advertise<Decision>("decision", 1, true);
    sample_ = node.subscribe("battery_state", 1000, &EnergyManager::onSample, this);
    engine_ = node.subscribe("engine_off", 10, &EnergyManager::onEngine, this);
    status_ = node.subscribe(battery_ + "/status", 10, &EnergyManager::onStatus, this);
    timer_ = node.createSteadyTimer(ros::WallDuration(0.1),
                                    [this](const ros::SteadyTimerEvent&) { publish(); });
    asker_ = std::thread([this] { askOnAndOn(); });
  }

  /// Shutting down ends a call that is under way.
  ~EnergyManager() {
    ros::shutdown();
    asker_.join();
  }

 private:
  void onSample(const sensor_msgs::BatteryState& sample) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (engine_is_off_ && sample.current > 0.5 * rule_.i_cranking && std::isfinite(sample.current))
      habits_.addStanding(sample.current);
  }

  void onEngine(const std_msgs::Bool& off) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (engine_is_off_ && !off.data) habits_.endStop();
    if (!off.data) restart_ = false;
    engine_is_off_ = off.data;
  }

  void onStatus(const battery_sof::SofStatus& status) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (status.past_cranks.count > cranks_) habits_.addCrank(status.past_cranks.stimulus);
    cranks_ = status.past_cranks.count;
    is_ready_ = status.state == battery_sof::SofStatus::READY;
    status_reason_ = status.reason;
    status_came_ = ros::SteadyTime::now();
  }

  void askOnAndOn() {
    while (ros::ok()) {
      const ros::SteadyTime asked = ros::SteadyTime::now();
      if (const std::optional<Answers> answers = ask()) {
        const std::lock_guard<std::mutex> lock(mutex_);
        answers_ = answers;
        asked_ = asked;
      }
      ros::WallDuration(0.1).sleep();
    }
  }

  /// @return none when a service did not answer.
  std::optional<Answers> ask() {
    battery_sof::PredictCranking crank;
    battery_sof::PredictStopTime stop;
    battery_sof::PredictChargeAcceptance charge;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      crank.request.i_load = stop.request.i_load = habits_.load();
      crank.request.i_cranking = stop.request.i_cranking = habits_.cranking();
    }
    crank.request.t_stop = rule_.look_ahead;
    crank.request.t_cranking = stop.request.t_cranking = rule_.t_cranking;
    crank.request.u_required = rule_.u_required;
    stop.request.u_required = rule_.u_required + rule_.margin;
    charge.request.u_boost = rule_.u_boost;
    charge.request.t_sof2 = rule_.t_boost;
    charge.request.i_limit = rule_.i_limit;
    const bool came = ros::service::call(battery_ + "/predict_cranking", crank) &&
                      ros::service::call(battery_ + "/predict_stop_time", stop) &&
                      ros::service::call(battery_ + "/predict_charge_acceptance", charge);
    if (!came) return std::nullopt;
    return Answers{answerOf(crank.response), answerOf(stop.response), answerOf(charge.response)};
  }

  static double age(const ros::SteadyTime& then) {
    return then.isZero() ? std::numeric_limits<double>::infinity()
                         : (ros::SteadyTime::now() - then).toSec();
  }

  /// Why the answers are not to be used; empty when they are.
  std::string whyNoAnswers() const {
    if (age(asked_) > max_age_) return "the engine runs: no answer from " + battery_;
    if (age(status_came_) > 2.0 + max_age_) return "the engine runs: no status from " + battery_;
    return is_ready_ ? "" : "the engine runs: " + status_reason_;
  }

  void publish() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const std::string why = whyNoAnswers();
    const Verdict verdict = decide(rule_, why.empty() ? answers_ : std::nullopt, why);
    restart_ = engine_is_off_ && (restart_ || !verdict.may_stop);
    Decision decision;
    decision.header.stamp = ros::Time::now();
    decision.may_stop = verdict.may_stop && !restart_;
    decision.restart = restart_;
    decision.longest_stop = decision.may_stop ? verdict.longest_stop : 0.0;
    decision.reserve = verdict.reserve;
    decision.planned_charge = verdict.planned_charge;
    decision.reason = verdict.may_stop && restart_
                          ? "the engine has to start, as was decided earlier in this stop"
                          : verdict.reason;
    decisions_.publish(decision);
  }

  const Rule rule_;
  std::mutex mutex_;
  Habits habits_;
  const double max_age_;  // [s]
  const std::string battery_;
  bool engine_is_off_ = false, restart_ = false, is_ready_ = false;
  std::uint32_t cranks_ = 0;
  std::string status_reason_;
  std::optional<Answers> answers_;
  ros::SteadyTime asked_, status_came_;
  ros::Publisher decisions_;
  ros::Subscriber sample_, engine_, status_;
  ros::SteadyTimer timer_;
  std::thread asker_;
};

}  // namespace
}  // namespace energy_manager

int main(int argc, char** argv) {
  ros::init(argc, argv, "energy_manager");
  try {
    energy_manager::EnergyManager manager{ros::NodeHandle(), ros::NodeHandle("~")};
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 2;
  }
  return 0;
}
