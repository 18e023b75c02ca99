#pragma once

#include "reference/full_battery.hpp"

namespace battery_sof_reference {

/// What is asked of generator and consumers over one step.
struct Demand {
  double current =
      0.0;  ///< wanted at the step's end [A]; while charging the generator's current limit
  double voltage_limit = 14.2;  ///< set point of the generator [V]
};

/**
 * @brief Generator, consumers and wiring at the battery's terminals.
 *
 * Current-controlled while the battery's voltage stays at or below the set point: the current is
 * the wanted one. Voltage-controlled otherwise: the current, between 0 and the wanted one, holds
 * the voltage at the set point to within 1 uV, so it follows from the battery. A generator cannot
 * draw current, and consumers are not limited. The current changes by at most slew times
 * FullBattery::kStep a step; while it does, the voltage may pass the set point.
 */
class PowerSource {
 public:
  /// @param slew [A/s], > 0; 3 kA/s for starter and wiring (PHYSICS 4.4).
  explicit PowerSource(double slew = 3000.0) : slew_(slew) {}

  /// @return the battery one step later.
  BatteryState step(const FullBattery& battery, const BatteryState& before,
                    const Demand& demand) const;

 private:
  double slew_;
};

}  // namespace battery_sof_reference
