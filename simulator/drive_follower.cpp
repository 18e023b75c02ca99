#include "simulator/drive_follower.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace battery_sof_simulator {

constexpr double kStep = FullBattery::kStep;  // [s]; phases count in it
constexpr double kSameTime = 1e-9;            // [s], what rounding leaves of a difference

namespace {

/// How long a scenario's first profile is planned for [s].
double plannedLength(const Scenario& scenario, double duration) {
  return scenario.later ? scenario.later->from : std::max(duration, scenario.duration);
}

}  // namespace

DriveFollower::DriveFollower(const Scenario& scenario, double duration)
    : plan_(planDrive(scenario.profile, plannedLength(scenario, duration), scenario.seed)),
      change_at_(std::numeric_limits<long>::max()),
      inserts_(scenario.inserts.begin(), scenario.inserts.end()),
      voltage_limit_(scenario.voltage_limit) {
  if (!scenario.later) return;
  const LaterPart& later = *scenario.later;
  const double left = std::max(duration, scenario.duration) - later.from;
  // Other random numbers than the first profile's.
  later_plan_ = planDrive(later.profile, left, ~scenario.seed);
  later_voltage_limit_ = later.voltage_limit;
  change_at_ = std::lround(later.from / kStep);
}

Demand DriveFollower::next(double charge_ah) {
  if (steps_ == change_at_) changePlan(charge_ah);
  while (inside_ >= length_) begin(charge_ah);
  ++inside_;
  ++steps_;
  const double share = static_cast<double>(inside_) / static_cast<double>(length_);
  const bool own_limit = std::isfinite(phase_.voltage_limit);
  return {phase_.begin + share * (phase_.end - phase_.begin),
          own_limit ? phase_.voltage_limit : voltage_limit_};
}

void DriveFollower::changePlan(double charge_ah) {
  const double time = static_cast<double>(steps_) * kStep;
  plan_ = std::move(later_plan_);
  plan_began_ = {time, charge_ah};
  voltage_limit_ = later_voltage_limit_;
  waiting_.clear();
  while (!inserts_.empty() && inserts_.front().at < time - kSameTime) inserts_.pop_front();
  inside_ = length_;
}

void DriveFollower::begin(double charge_ah) {
  const double time = static_cast<double>(steps_) * kStep;
  if (waiting_.empty() && !inserts_.empty() && time >= inserts_.front().at - kSameTime) {
    waiting_.assign(inserts_.front().phases.begin(), inserts_.front().phases.end());
    inserts_.pop_front();
  }
  const Situation now{time - plan_began_.time, charge_ah - plan_began_.charge_ah};
  phase_ = waiting_.empty() ? plan_->next(now) : waiting_.front();
  if (!waiting_.empty()) waiting_.pop_front();
  length_ = std::max(1L, std::lround(phase_.duration / kStep));
  inside_ = 0;
}

}  // namespace battery_sof_simulator
