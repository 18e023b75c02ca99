#pragma once

#include <deque>
#include <memory>

#include "simulator/power_source.hpp"
#include "simulator/simulation.hpp"

namespace battery_sof_simulator {

/// Follows a scenario's profile, its later part and inserts in whole steps of FullBattery::kStep.
class DriveFollower {
 public:
  /// @param duration of what is simulated [s]; shorter than the scenario's: the same drive, cut.
  DriveFollower(const Scenario& scenario, double duration);

  /// What is wanted at the end of the next step. @param charge_ah taken up so far [Ah].
  Demand next(double charge_ah);

 private:
  void begin(double charge_ah);
  /// Takes up the later part when its time has come.
  void changePlan(double charge_ah);

  std::unique_ptr<DrivePlan> plan_, later_plan_;
  double later_voltage_limit_ = 0.0;
  long change_at_;                  // in steps; the largest number: never
  Situation plan_began_{0.0, 0.0};  // what a plan is reported counts from there
  std::deque<Insert> inserts_;
  std::deque<Phase> waiting_;
  double voltage_limit_;
  Phase phase_{};
  long length_ = 0, inside_ = 0, steps_ = 0;
};

}  // namespace battery_sof_simulator
