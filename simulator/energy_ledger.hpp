#pragma once

#include "simulator/full_battery.hpp"

namespace battery_sof_simulator {

/// Charge and energy books over a stretch of time.
struct Balance {
  double charge_in = 0.0;    ///< int i dt [As]
  double main_charge = 0.0;  ///< 3600 C_20 dSOC [As]
  double gas_charge = 0.0;   ///< [As]
  double energy_in = 0.0;    ///< int u i dt [J]
  double throughput = 0.0;   ///< int |u i| dt [J]
  double stored = 0.0;       ///< change of what every element keeps [J]
  Losses lost{};             ///< int losses dt [J], by element

  double chargeError() const { return charge_in - main_charge - gas_charge; }  ///< [As]
  double energyError() const { return energy_in - stored - lost.total(); }     ///< [J]
};

/**
 * @brief Keeps the books of a simulated battery: what went in, where it is, what was lost.
 *
 *     int i dt = 3600 C_20 dSOC + gassing charge,      int u i dt = d(stored) + int losses dt
 *
 * Current and power are those entering the block, behind a parasitic load. Integrated by the
 * trapezoidal rule over the steps' ends, separately from the battery's own integration, so that the
 * balances test the latter. The voltage across L changes within a step's current ramp and is taken
 * exactly.
 */
class EnergyLedger {
 public:
  /// @param battery outlives the ledger.
  EnergyLedger(const FullBattery& battery, const BatteryState& start);

  /// Enters one step, from the state entered last (or the start) to this one.
  void enter(const BatteryState& after);

  const Balance& balance() const { return balance_; }

 private:
  const FullBattery* battery_;
  Losses last_power_;
  double last_current_, last_terminal_power_, last_inductance_;
  double stored_at_start_;
  Balance balance_;
};

}  // namespace battery_sof_simulator
