#include "simulator/battery_parameters.hpp"

#include <algorithm>
#include <cmath>

#include "simulator/battery_elements.hpp"
#include "simulator/fields.hpp"
#include "simulator/units.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kOhmicShare = 0.4;  // of the smaller total resistance

/// r_1 is a one-to-one law only then; looked at where s of its definition changes.
bool r1Rises(const BatteryParameters& p) {
  for (int tenth = -200; tenth <= 200; ++tenth) {
    const double current = p.r1_transition_at_a + 0.1 * tenth * p.r1_transition_a;
    if (r1Voltage(p, BatteryEffects{}, current).slope <= 0.0) return false;
  }
  return true;
}

}  // namespace

void setResistances(BatteryParameters& battery, double r_discharge, double r_charge) {
  battery.r_ohmic_ohm = kOhmicShare * std::min(r_discharge, r_charge);
  battery.r1_discharge_ohm = r_discharge - battery.r_ohmic_ohm;
  battery.r1_charge_ohm = r_charge - battery.r_ohmic_ohm;
}

BatteryEffects plainCircuit() {
  BatteryEffects effects;
  effects.inductance = effects.cpe1 = effects.cpe1_fractional = effects.cpe2_fractional = false;
  effects.r1_smooth = effects.r1_current_dependence = effects.ocv_slope = false;
  effects.gassing = GassingLaw::kNone;
  return effects;
}

Cpe cpe1Of(const BatteryParameters& parameters, const BatteryEffects& effects) {
  if (!effects.cpe1) return {};
  const double p = effects.cpe1_fractional ? parameters.cpe1_exponent : 1.0;
  const double r1 = 0.5 * (parameters.r1_charge_ohm + parameters.r1_discharge_ohm);
  return {std::pow(2.0 * kPi * parameters.cpe1_corner_hz, -p) / r1, p};
}

Cpe cpe2Of(const BatteryParameters& parameters, const BatteryEffects& effects) {
  const double p = effects.cpe2_fractional ? parameters.cpe2_exponent : 1.0;
  return {parameters.cpe2_capacitance_f * std::pow(parameters.cpe2_reference_rad_per_s, 1.0 - p),
          p};
}

std::vector<std::string> faultsOf(const BatteryParameters& parameters) {
  auto faults = fieldFaults(parameters);
  if (faults.empty() && !r1Rises(parameters))
    faults.push_back(
        "r1_charge_ohm and r1_discharge_ohm are so different that the voltage across r_1 "
        "falls while its current rises; expected a wider r1_transition_a or a larger "
        "r1_knee_current_a");
  return faults;
}

}  // namespace battery_sof_simulator
