#include "reference/power_source.hpp"

#include <algorithm>
#include <cmath>

namespace battery_sof_reference {
namespace {

constexpr double kVoltageTolerance = 1e-6;  // [V]
constexpr double kProbe = 0.5;              // [A], second point of the secant
constexpr int kMostIterations = 40;

/// The state whose voltage is the set point; the current lies between 0 and the one that exceeds
/// it.
BatteryState holdVoltage(const FullBattery& battery, const BatteryState& before, double set_point,
                         const BatteryState& above) {
  double low = 0.0, high = above.current;
  double x = high, excess = battery.voltage(above) - set_point;
  double next = std::clamp(before.current, low, high - std::min(kProbe, 0.5 * high));
  BatteryState state = above;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
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

}  // namespace

BatteryState PowerSource::step(const FullBattery& battery, const BatteryState& before,
                               const Demand& demand) const {
  const double reach = slew_ * FullBattery::kStep;
  const double lowest = before.current - reach, highest = before.current + reach;
  const BatteryState free = battery.advance(before, std::clamp(demand.current, lowest, highest));
  if (free.current <= 0.0 || battery.voltage(free) <= demand.voltage_limit) return free;
  BatteryState held = battery.advance(before, 0.0);
  if (battery.voltage(held) < demand.voltage_limit)
    held = holdVoltage(battery, before, demand.voltage_limit, free);
  if (held.current >= lowest) return held;
  return battery.advance(before, lowest);
}

}  // namespace battery_sof_reference
