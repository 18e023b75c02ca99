#pragma once

#include "simulator/battery_parameters.hpp"

namespace battery_sof_simulator {

/// A law at one point and its derivative there.
struct Linearised {
  double value, slope;
};

/// Parameters that do not stay what they are, at one instant.
struct Conditions {
  double r_ohmic;            ///< r_i [Ohm]
  double r1_factor;          ///< of r_1 [1]
  double i0;                 ///< I_0 [A]
  double lead_ion_limit;     ///< i_lim [A]
  double gas_current;        ///< I_g at 14.4 V [A]
  double cpe2_factor = 1.0;  ///< of CPE2's scale [1]
  double u0_factor = 1.0;    ///< of u_0 [1]
};

/**
 * @brief Temperature dependence of Fig. 4's elements.
 *
 *     r = r_25 (1 + k (T - 25)),   I_0 = I_0,25 exp(E_a/R (1/298.15 - 1/T)),   i_lim = i_lim,25
 * 2^((T - 25)/15), I_g = I_g,25 exp(c_T (T - 25))
 *
 * @param temperature [degC], -40 to 80. L, both CPEs, u_0 and the gassing threshold are taken as
 * constant.
 */
Conditions atTemperature(const BatteryParameters& parameters, double temperature);

/**
 * @brief Voltage across r_1 and dv/di (paper, III-B; docs/physics.md#reference-circuit).
 *
 *     v = r(i) i,   r(i) = [r_1c s + r_1d (1 - s)] / (1 + |i| / i_x)
 *     s = 1 / (1 + exp(-(i - i_s) / i_w))
 *
 * @param current through r_1 [A].  @return [V], [Ohm] at 25 degC; the slope at a kink is that of
 * the charging side.
 */
Linearised r1Voltage(const BatteryParameters& parameters, const BatteryEffects& effects,
                     double current);

/// The two exponentials of eq. 1: forward I_0 exp(alpha beta u), backward I_0 exp((alpha - 1) beta
/// u) [A].
struct ReactionRates {
  double forward, backward;
};
ReactionRates reactionRates(const BatteryParameters& parameters, double i0, double u2);

/**
 * @brief Charge-transfer current (paper, eq. 1) at a relative Pb2+ concentration p
 * (docs/physics.md#charge_acceptance; p = 1 is eq. 1 itself).
 *
 *     i_r2 = I_0 { p exp(alpha beta u) - exp((alpha - 1) beta u) }
 *
 * @return [A] and its derivative to u2 at constant p [1/Ohm].
 */
Linearised chargeTransfer(const BatteryParameters& parameters, double i0, double u2,
                          double lead_ion);

/// Current of the gassing branch across U_x = u_0 + u_2 [V]: [A], [1/Ohm]; both >= 0.
Linearised gassing(const BatteryParameters& parameters, GassingLaw law, const Conditions& at,
                   double u_x);

/// Open-circuit voltage u_0 = u0_v + u0_slope_v (SOC - 0.8) [V] and its slope [V per unit of SOC].
Linearised openCircuitVoltage(const BatteryParameters& parameters, double soc);

}  // namespace battery_sof_simulator
