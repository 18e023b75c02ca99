#include "simulator/battery_elements.hpp"

#include <algorithm>
#include <cmath>

#include "simulator/fields.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kOhmicShare = 0.4;  // of the smaller total resistance

constexpr double kGasConstant = 8.314462618;  // [J/(mol K)]
constexpr double kReferenceCelsius = 25.0;
constexpr double kZeroCelsius = 273.15;  // [K]
constexpr double kTafelVoltage = 14.4;   // [V], 2.4 V a cell

/// Share of the charging value in r_1 and its derivative to current.
Linearised chargingShare(const BatteryParameters& p, const BatteryEffects& effects,
                         double current) {
  if (!effects.r1_asymmetry) return {0.5, 0.0};
  if (!effects.r1_smooth) return {current < 0.0 ? 0.0 : 1.0, 0.0};
  const double s = 1.0 / (1.0 + std::exp(-(current - p.r1_transition_at_a) / p.r1_transition_a));
  return {s, s * (1.0 - s) / p.r1_transition_a};
}

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

Conditions atTemperature(const BatteryParameters& p, double temperature) {
  const double warmer = temperature - kReferenceCelsius;
  const double resistance = 1.0 + p.r_per_k * warmer;
  const double inverse =
      1.0 / (kReferenceCelsius + kZeroCelsius) - 1.0 / (temperature + kZeroCelsius);
  return {p.r_ohmic_ohm * resistance, resistance,
          p.i0_a * std::exp(p.activation_j_per_mol / kGasConstant * inverse),
          p.lead_ion_limit_a * std::exp2(warmer / p.lead_ion_halving_k),
          p.gas_current_a * std::exp(p.gas_slope_per_k * warmer)};
}

Linearised r1Voltage(const BatteryParameters& p, const BatteryEffects& effects, double current) {
  const Linearised share = chargingShare(p, effects, current);
  const double step = p.r1_charge_ohm - p.r1_discharge_ohm;
  const double r = p.r1_discharge_ohm + step * share.value;
  const double falling = effects.r1_current_dependence ? p.r1_knee_share : 0.0;
  const double knee = 1.0 / (1.0 + std::abs(current) / p.r1_knee_current_a);
  const double factor = 1.0 - falling + falling * knee;
  return {r * factor * current,
          step * share.slope * factor * current + r * (1.0 - falling + falling * knee * knee)};
}

ReactionRates reactionRates(const BatteryParameters& p, double i0, double u2) {
  return {i0 * std::exp(p.alpha * p.beta_per_v * u2),
          i0 * std::exp((p.alpha - 1.0) * p.beta_per_v * u2)};
}

Linearised chargeTransfer(const BatteryParameters& p, double i0, double u2, double lead_ion) {
  const ReactionRates rates = reactionRates(p, i0, u2);
  return {lead_ion * rates.forward - rates.backward,
          p.beta_per_v * (p.alpha * lead_ion * rates.forward + (1.0 - p.alpha) * rates.backward)};
}

Linearised gassing(const BatteryParameters& p, GassingLaw law, const Conditions& at, double u_x) {
  if (law == GassingLaw::kTafel) {
    const double current = at.gas_current * std::exp(p.gas_slope_per_v * (u_x - kTafelVoltage));
    return {current, p.gas_slope_per_v * current};
  }
  if (law == GassingLaw::kNone || u_x < p.u_gas_v) return {0.0, 0.0};
  return {(u_x - p.u_gas_v) / p.r_gas_ohm, 1.0 / p.r_gas_ohm};
}

Linearised openCircuitVoltage(const BatteryParameters& p, double soc) {
  return {p.u0_v + p.u0_slope_v * (soc - kReferenceSoc), p.u0_slope_v};
}

}  // namespace battery_sof_simulator
