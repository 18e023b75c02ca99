#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "simulator/simulation.hpp"

namespace battery_sof_simulator {

/// What the sensors do not see of a drive of Fig. 4's battery, one entry every FullBattery::kStep;
/// entry 0 stands at the start.
struct Truth {
  std::vector<double> current;  ///< [A]
  std::vector<double> voltage;  ///< at the terminals [V]
  std::vector<double> soc;      ///< [1]
  Balance balance;
};

/// The truth of the drive that simulate() records.
inline Truth truthOf(const Scenario& scenario, int substeps = 1,
                     std::optional<double> cut_after = std::nullopt) {
  const double duration = cut_after.value_or(scenario.duration);
  const FullBattery battery(scenario.battery, scenario.effects, scenario.start, substeps,
                            scenario.additions);
  EnergyLedger ledger(battery, battery.rested());
  Truth truth;
  const auto look = [&](const BatteryState& state, long n) {
    if (n > 0) ledger.enter(state);
    truth.current.push_back(state.current);
    truth.voltage.push_back(battery.voltage(state));
    truth.soc.push_back(battery.soc(state));
    return ledger.balance().charge_in / kSecondsPerHour;
  };
  driveThrough(battery, scenario, duration, std::lround(duration / FullBattery::kStep), look);
  truth.balance = ledger.balance();
  return truth;
}

}  // namespace battery_sof_simulator
