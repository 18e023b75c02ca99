#include "simulator/battery_elements.hpp"

#include <cmath>

namespace battery_sof_simulator {
namespace {

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

}  // namespace

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
