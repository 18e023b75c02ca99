#include "simulator/energy_ledger.hpp"

#include <cmath>

namespace battery_sof_simulator {
namespace {

void addScaled(Losses& sum, const Losses& a, const Losses& b, double factor) {
  sum.r_ohmic += factor * (a.r_ohmic + b.r_ohmic);
  sum.r1 += factor * (a.r1 + b.r1);
  sum.cpe1 += factor * (a.cpe1 + b.cpe1);
  sum.charge_transfer += factor * (a.charge_transfer + b.charge_transfer);
  sum.lead_ion += factor * (a.lead_ion + b.lead_ion);
  sum.cpe2 += factor * (a.cpe2 + b.cpe2);
  sum.gassing += factor * (a.gassing + b.gassing);
  sum.added += factor * (a.added + b.added);
}

/// u i without the inductance, whose energy is known exactly.
double terminalPower(const FullBattery& battery, const BatteryState& state) {
  return battery.voltageWithoutInductance(state) * battery.batteryCurrent(state);
}

}  // namespace

EnergyLedger::EnergyLedger(const FullBattery& battery, const BatteryState& start)
    : battery_(&battery),
      last_power_(battery.losses(start)),
      last_current_(battery.batteryCurrent(start)),
      last_terminal_power_(terminalPower(battery, start)),
      last_inductance_(battery.stored(start).inductance),
      stored_at_start_(battery.stored(start).total()) {}

void EnergyLedger::enter(const BatteryState& after) {
  const double half = 0.5 * FullBattery::kStep;
  const Losses power = battery_->losses(after);
  const StoredEnergy stored = battery_->stored(after);
  const double terminal_power = terminalPower(*battery_, after);
  const double current = battery_->batteryCurrent(after);
  balance_.charge_in += half * (last_current_ + current);
  balance_.main_charge = after.main_charge;
  balance_.gas_charge = after.gas_charge;
  balance_.energy_in +=
      half * (last_terminal_power_ + terminal_power) + stored.inductance - last_inductance_;
  balance_.throughput += half * (std::abs(last_terminal_power_) + std::abs(terminal_power));
  balance_.stored = stored.total() - stored_at_start_;
  addScaled(balance_.lost, last_power_, power, half);
  last_power_ = power;
  last_current_ = current;
  last_terminal_power_ = terminal_power;
  last_inductance_ = stored.inductance;
}

}  // namespace battery_sof_simulator
