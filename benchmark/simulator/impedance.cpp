#include "simulator/impedance.hpp"

#include <stdexcept>

namespace battery_sof_simulator {
namespace {

using Complex = std::complex<double>;
constexpr double kCurrentTolerance = 1e-10;  // [A]

/// Steady i_r2 with p = 1 - i_r2 / i_lim put in: i = (forward - backward) / (1 + forward / i_lim).
Linearised steadyTransfer(const BatteryParameters& parameters, const Conditions& at, bool limited,
                          double u2) {
  const ReactionRates rates = reactionRates(parameters, at.i0, u2);
  const Linearised free = chargeTransfer(parameters, at.i0, u2, 1.0);
  if (!limited) return free;
  const double divisor = 1.0 + rates.forward / at.lead_ion_limit;
  const double divisor_slope =
      parameters.alpha * parameters.beta_per_v * rates.forward / at.lead_ion_limit;
  const double value = free.value / divisor;
  return {value, (free.slope - value * divisor_slope) / divisor};
}

double steadyOverpotential(const BatteryParameters& parameters, const BatteryEffects& effects,
                           const Conditions& at, double u0, double current) {
  const auto excess = [&](double u2) {
    const Linearised main = steadyTransfer(parameters, at, effects.charge_acceptance, u2);
    const Linearised gas = gassing(parameters, effects.gassing, at, u0 + u2);
    return Linearised{main.value + gas.value - current, main.slope + gas.slope};
  };
  const double near = 2.0 / parameters.beta_per_v * std::asinh(0.5 * current / at.i0);
  return increasingRoot(excess, near, kCurrentTolerance * (1.0 + std::abs(current)));
}

void requireValid(const BatteryParameters& parameters, const FullBattery::Start& start,
                  double current, const std::vector<double>& frequencies) {
  // The constructor names every fault.
  FullBattery(parameters, BatteryEffects{}, start);
  if (!std::isfinite(current)) throw std::invalid_argument("impedance: current is not finite");
  for (double f : frequencies)
    if (!(f > 0.0) || !std::isfinite(f))
      throw std::invalid_argument("impedance: frequency is " + std::to_string(f) +
                                  " Hz, expected above 0");
}

}  // namespace

std::vector<ImpedancePoint> impedance(const BatteryParameters& parameters,
                                      const BatteryEffects& effects,
                                      const FullBattery::Start& start, double current,
                                      const std::vector<double>& frequencies) {
  requireValid(parameters, start, current, frequencies);
  const Conditions at = atTemperature(parameters, start.temperature);
  const bool limited = effects.charge_acceptance;
  if (limited && effects.gassing == GassingLaw::kNone && current >= at.lead_ion_limit)
    throw std::invalid_argument("impedance: current is " + std::to_string(current) +
                                " A, expected below the Pb2+ limit, which no charge lasts above");
  const double u0 = openCircuitVoltage(parameters, start.soc).value;
  const double u2 = steadyOverpotential(parameters, effects, at, u0, current);
  const double main = steadyTransfer(parameters, at, limited, u2).value;
  const double lead_ion = limited ? 1.0 - main / at.lead_ion_limit : 1.0;
  const double inductance = effects.inductance ? parameters.inductance_h : 0.0;
  const double r1 = at.r1_factor * r1Voltage(parameters, effects, current).slope;
  const double transfer = chargeTransfer(parameters, at.i0, u2, lead_ion).slope;
  const double forward = reactionRates(parameters, at.i0, u2).forward;
  const double gas = gassing(parameters, effects.gassing, at, u0 + u2).slope;
  const double soc_stiffness =
      effects.ocv_slope ? parameters.u0_slope_v / (kSecondsPerHour * parameters.capacity_ah) : 0.0;
  const auto impedanceAt = [&](Complex jw, Complex y_cpe1, Complex y_cpe2) {
    const Complex y_r2 =
        limited
            ? transfer /
                  (1.0 + forward / (at.lead_ion_limit * (1.0 + jw * parameters.lead_ion_time_s)))
            : transfer;
    const Complex reaction = soc_stiffness / jw + 1.0 / (y_r2 + y_cpe2);
    return jw * inductance + at.r_ohmic + 1.0 / (1.0 / r1 + y_cpe1) + 1.0 / (1.0 / reaction + gas);
  };
  const Cpe cpe1 = cpe1Of(parameters, effects), cpe2 = cpe2Of(parameters, effects);
  const CpeLadder ladder1(cpe1), ladder2(cpe2);
  std::vector<ImpedancePoint> spectrum;
  for (double frequency : frequencies) {
    const double w = 2.0 * kPi * frequency;
    const Complex jw(0.0, w);
    spectrum.push_back({frequency, impedanceAt(jw, ladder1.admittance(w), ladder2.admittance(w)),
                        impedanceAt(jw, analyticAdmittance(cpe1, w), analyticAdmittance(cpe2, w))});
  }
  return spectrum;
}

std::vector<double> logarithmicFrequencies(double first, double last, int per_decade) {
  const int steps = static_cast<int>(std::lround(std::log10(last / first) * per_decade));
  std::vector<double> frequencies;
  for (int k = 0; k <= steps; ++k)
    frequencies.push_back(first * std::pow(last / first, static_cast<double>(k) / steps));
  return frequencies;
}

}  // namespace battery_sof_simulator
