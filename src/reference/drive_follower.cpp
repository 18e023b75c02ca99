#include "reference/drive_follower.hpp"

#include <algorithm>
#include <cmath>

namespace battery_sof_reference {

constexpr double kStep = FullBattery::kStep;  // [s]; phases count in it

DriveFollower::DriveFollower(const Scenario& scenario, double duration)
    : plan_(planDrive(scenario.profile, std::max(duration, scenario.duration), scenario.seed)),
      inserts_(scenario.inserts.begin(), scenario.inserts.end()),
      voltage_limit_(scenario.voltage_limit) {}

Demand DriveFollower::next(double charge_ah) {
  while (inside_ >= length_) begin(charge_ah);
  ++inside_;
  ++steps_;
  const double share = static_cast<double>(inside_) / static_cast<double>(length_);
  const bool own_limit = std::isfinite(phase_.voltage_limit);
  return {phase_.begin + share * (phase_.end - phase_.begin),
          own_limit ? phase_.voltage_limit : voltage_limit_};
}

void DriveFollower::begin(double charge_ah) {
  const double time = static_cast<double>(steps_) * kStep;
  if (waiting_.empty() && !inserts_.empty() && time >= inserts_.front().at) {
    waiting_.assign(inserts_.front().phases.begin(), inserts_.front().phases.end());
    inserts_.pop_front();
  }
  phase_ = waiting_.empty() ? plan_->next({time, charge_ah}) : waiting_.front();
  if (!waiting_.empty()) waiting_.pop_front();
  length_ = std::max(1L, std::lround(phase_.duration / kStep));
  inside_ = 0;
}

}  // namespace battery_sof_reference
