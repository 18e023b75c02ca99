#include "simulator/impedance.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "simulator/increasing_root.hpp"
#include "simulator/units.hpp"

namespace battery_sof_simulator {
namespace {

using Complex = std::complex<double>;
constexpr double kCurrentTolerance = 1e-10;  // [A]

/// Fig. 4 linearised: what of each element does not depend on frequency.
struct SmallSignal {
  double inductance, r_ohmic, r1;
  double transfer;        // di_r2/du_2 at constant Pb2+ [1/Ohm]
  double forward;         // I_0 exp(alpha beta u_2) [A]
  double lead_ion_limit;  // [A]; 0: none
  double lead_ion_time;   // [s]
  double gassing;         // [1/Ohm]
  double soc_stiffness;   // u_0' / (3600 C_20) [V/As]
};

double u0At(const BatteryParameters& parameters, const OperatingPoint& point) {
  return openCircuitVoltage(parameters, point.soc).value;
}

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
                           const Conditions& at, const OperatingPoint& point) {
  const auto excess = [&](double u2) {
    const Linearised main = steadyTransfer(parameters, at, effects.charge_acceptance, u2);
    const Linearised gas = gassing(parameters, effects.gassing, at, u0At(parameters, point) + u2);
    return Linearised{main.value + gas.value - point.current, main.slope + gas.slope};
  };
  const double near = 2.0 / parameters.beta_per_v * std::asinh(0.5 * point.current / at.i0);
  return increasingRoot(excess, near, kCurrentTolerance * (1.0 + std::abs(point.current)));
}

SmallSignal linearised(const BatteryParameters& parameters, const BatteryEffects& effects,
                       const OperatingPoint& point) {
  const Conditions at = atTemperature(parameters, point.temperature);
  const double u2 = steadyOverpotential(parameters, effects, at, point);
  const double main = steadyTransfer(parameters, at, effects.charge_acceptance, u2).value;
  const double lead_ion = effects.charge_acceptance ? 1.0 - main / at.lead_ion_limit : 1.0;
  SmallSignal s{};
  s.inductance = effects.inductance ? parameters.inductance_h : 0.0;
  s.r_ohmic = at.r_ohmic;
  s.r1 = at.r1_factor * r1Voltage(parameters, effects, point.current).slope;
  s.transfer = chargeTransfer(parameters, at.i0, u2, lead_ion).slope;
  s.forward = reactionRates(parameters, at.i0, u2).forward;
  s.lead_ion_limit = effects.charge_acceptance ? at.lead_ion_limit : 0.0;
  s.lead_ion_time = parameters.lead_ion_time_s;
  s.gassing = gassing(parameters, effects.gassing, at, u0At(parameters, point) + u2).slope;
  s.soc_stiffness =
      effects.ocv_slope ? parameters.u0_slope_v / (kSecondsPerHour * parameters.capacity_ah) : 0.0;
  return s;
}

Complex transferAdmittance(const SmallSignal& s, Complex jw) {
  if (s.lead_ion_limit == 0.0) return s.transfer;
  return s.transfer / (1.0 + s.forward / (s.lead_ion_limit * (1.0 + jw * s.lead_ion_time)));
}

Complex impedanceOf(const SmallSignal& s, double omega, Complex y_cpe1, Complex y_cpe2) {
  const Complex jw(0.0, omega);
  const Complex reaction = s.soc_stiffness / jw + 1.0 / (transferAdmittance(s, jw) + y_cpe2);
  return jw * s.inductance + s.r_ohmic + 1.0 / (1.0 / s.r1 + y_cpe1) +
         1.0 / (1.0 / reaction + s.gassing);
}

void requireValid(const BatteryParameters& parameters, const OperatingPoint& point,
                  const std::vector<double>& frequencies) {
  // The constructor names every fault.
  FullBattery(parameters, BatteryEffects{}, {point.soc, point.temperature});
  if (!std::isfinite(point.current))
    throw std::invalid_argument("impedance: current is not finite");
  for (double f : frequencies)
    if (!(f > 0.0) || !std::isfinite(f))
      throw std::invalid_argument("impedance: frequency is " + std::to_string(f) +
                                  " Hz, expected above 0");
}

}  // namespace

std::vector<ImpedancePoint> impedance(const BatteryParameters& parameters,
                                      const BatteryEffects& effects, const OperatingPoint& point,
                                      const std::vector<double>& frequencies) {
  requireValid(parameters, point, frequencies);
  if (effects.charge_acceptance && effects.gassing == GassingLaw::kNone &&
      point.current >= atTemperature(parameters, point.temperature).lead_ion_limit)
    throw std::invalid_argument("impedance: current is " + std::to_string(point.current) +
                                " A, expected below the Pb2+ limit, which no charge lasts above");
  const SmallSignal s = linearised(parameters, effects, point);
  const Cpe cpe1 = cpe1Of(parameters, effects), cpe2 = cpe2Of(parameters, effects);
  const CpeLadder ladder1(cpe1), ladder2(cpe2);
  std::vector<ImpedancePoint> spectrum;
  for (double frequency : frequencies) {
    const double w = 2.0 * kPi * frequency;
    spectrum.push_back(
        {frequency, impedanceOf(s, w, ladder1.admittance(w), ladder2.admittance(w)),
         impedanceOf(s, w, analyticAdmittance(cpe1, w), analyticAdmittance(cpe2, w))});
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
