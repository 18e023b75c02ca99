#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "simulator/acquisition.hpp"
#include "simulator/drive_plan.hpp"
#include "simulator/full_battery.hpp"
#include "simulator/porous_block.hpp"

namespace battery_sof_simulator {

/// All that a simulated recording follows from.
struct Scenario {
  std::string name = "scenario";
  std::uint64_t seed = 1;          ///< the same scenario and seed give the same recording
  double duration = 900.0;         ///< planned length [s], > 0
  double voltage_limit = 14.2;     ///< generator's set point [V], > 0
  double slew = 3000.0;            ///< of the current [A/s], > 0
  double impedance_current = 0.0;  ///< direct current of the printed spectrum [A]
  BatteryParameters battery;
  BatteryEffects effects;
  Additions additions;
  std::optional<PorousParameters> porous;  ///< in place of the three above, at 25 degC
  FullBattery::Start start;
  AcquisitionOptions acquisition;
  ProfileOptions profile;
  std::vector<Insert> inserts;  ///< in order of time
  std::optional<LaterPart> later;
};

/// Has a drive play phases from an instant on [s], among those that are there.
void insertAt(Scenario& scenario, double at, const std::vector<Phase>& phases);

struct SimulationOptions {
  std::optional<double> cut_after;  ///< another length than planned [s]; a shorter drive is cut
  std::function<void(double)> progress;  ///< given the simulated time [s] once a simulated minute
};

/// A recording and how it came about.
struct Simulation {
  std::vector<RecordedSample> samples;
  std::vector<double> temperature;  ///< of the block, one a sample [degC]
  double duration = 0.0;            ///< [s]
  double soc_at_start = 0.0, soc_at_end = 0.0;
  Balance balance;  ///< of the recorded time
};

/// Drives the battery of Fig. 4 and its additions through a scenario and records it. A porous block
/// keeps of the balance only charges.
/// @throws std::invalid_argument naming every fault of the scenario; NoSolution of the equations.
Simulation simulate(const Scenario& scenario, const SimulationOptions& options = {});

/// Drives a battery through a scenario, cut or not.
/// @param duration of the drive [s].  @param steps that are taken, of kStep.
/// @param look is shown every state and its step, 0 at the start; returns the charge so far [Ah].
template <typename Battery, typename Look>
void driveThrough(const Battery& battery, const Scenario& scenario, double duration, long steps,
                  const Look& look) {
  DriveFollower driver(scenario, duration);
  const PowerSource source(scenario.slew);
  auto state = battery.rested();
  double charge_ah = look(state, 0);
  for (long n = 1; n <= steps; ++n) {
    state = source.step(battery, state, driver.next(charge_ah));
    charge_ah = look(state, n);
  }
}

/// @return one sentence for every fault of a scenario; empty when all is well.
std::vector<std::string> faultsOf(const Scenario& scenario);

}  // namespace battery_sof_simulator
