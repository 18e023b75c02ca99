#pragma once

#include <algorithm>
#include <cmath>

namespace battery_sof_simulator {

/// What is asked of generator and consumers over one step.
struct Demand {
  /// wanted at the step's end [A]; while charging the generator's current limit
  double current = 0.0;
  double voltage_limit = 14.2;  ///< set point of the generator [V]
};

/// Generator, consumers and wiring at the battery's terminals. Current-controlled while the
/// battery's voltage stays at or below the set point: the current is the wanted one.
/// Voltage-controlled otherwise: the current, between 0 and the wanted one, holds the voltage at
/// the set point to within 1 uV, so it follows from the battery. A generator cannot draw current,
/// and consumers are not limited. The current changes by at most slew times the battery's kStep a
/// step; while it does, the voltage may pass the set point. A Battery has a State with its current,
/// kStep, advance() and voltage(), as FullBattery and PorousBlock have.
class PowerSource {
 public:
  /// @param slew [A/s], > 0; 3 kA/s for starter and wiring (docs/physics.md#drives).
  explicit PowerSource(double slew = 3000.0) : slew_(slew) {}

  /// @return the battery one step later.
  template <typename Battery, typename State>
  State step(const Battery& battery, const State& before, const Demand& demand) const {
    const double reach = slew_ * Battery::kStep;
    const double lowest = before.current - reach, highest = before.current + reach;
    const State free = battery.advance(before, std::clamp(demand.current, lowest, highest));
    if (free.current <= 0.0 || battery.voltage(free) <= demand.voltage_limit) return free;
    State held = battery.advance(before, 0.0);
    if (battery.voltage(held) < demand.voltage_limit)
      held = holdVoltage(battery, before, demand.voltage_limit, free);
    if (held.current >= lowest) return held;
    return battery.advance(before, lowest);
  }

 private:
  /// The state whose voltage is the set point, with a current between 0 and that of `above`.
  template <typename Battery, typename State>
  static State holdVoltage(const Battery& battery, const State& before, double set_point,
                           const State& above) {
    double low = 0.0, high = above.current;
    double x = high, excess = battery.voltage(above) - set_point;
    double next = std::clamp(before.current, low, high - std::min(kProbe, 0.5 * high));
    State state = above;
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
      state = battery.advance(before, next);
      const double next_excess = battery.voltage(state) - set_point;
      if (std::abs(next_excess) <= kVoltageTolerance) break;
      (next_excess > 0.0 ? high : low) = next;
      const double secant = next - next_excess * (next - x) / (next_excess - excess);
      x = next;
      excess = next_excess;
      next = secant > low && secant < high ? secant : 0.5 * (low + high);
    }
    return state;
  }

  static constexpr double kVoltageTolerance = 1e-6;  // [V]
  static constexpr double kProbe = 0.5;              // [A], second point of the secant
  static constexpr int kMaxIterations = 40;

  double slew_;
};

}  // namespace battery_sof_simulator
