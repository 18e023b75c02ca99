#pragma once

#include <complex>
#include <vector>

#include "simulator/full_battery.hpp"

namespace battery_sof_simulator {

/// One line of a spectrum.
struct ImpedancePoint {
  double frequency;                ///< [Hz]
  std::complex<double> simulated;  ///< of the linearised simulated model, CPEs as ladders [Ohm]
  std::complex<double> analytic;   ///< CPEs as (jw)^p [Ohm]
};

/// Small-signal impedance of Fig. 4 at an operating point (paper, III-B).
///     Z = jwL + r_i + 1/(1/r_1' + Y_CPE1) + 1/( 1/(Z_u0 + 1/(Y_r2 + Y_CPE2)) + g_gas )
///     r_1' = d(r_1 i)/di,   Z_u0 = u_0' / (jw 3600 C_20),   g_gas = di_g/dU_x
///     Y_r2 = g / (1 + I_0 e^(alpha beta u) / (i_lim (1 + jw tau_d)))
///     g = di_r2/du_2 at constant Pb2+
/// The overvoltage is the steady one of I_dc; the slow drift of SOC under I_dc is left out.
/// @param current I_dc [A], below i_lim when charge_acceptance acts.  @param frequencies [Hz], > 0.
/// @throws std::invalid_argument for what is outside its range, or a current that cannot last.
std::vector<ImpedancePoint> impedance(const BatteryParameters& parameters,
                                      const BatteryEffects& effects,
                                      const FullBattery::Start& start, double current,
                                      const std::vector<double>& frequencies);

/// @return frequencies from first to last [Hz], `per_decade` to a decade, both ends included.
std::vector<double> logarithmicFrequencies(double first, double last, int per_decade);

}  // namespace battery_sof_simulator
