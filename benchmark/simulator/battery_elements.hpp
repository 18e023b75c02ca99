#pragma once

#include <string>
#include <vector>

#include "simulator/cpe_ladder.hpp"
#include "simulator/numerics.hpp"

namespace battery_sof_simulator {

/// Elements of the paper's Fig. 4 for a 12 V, 50 Ah VRLA block (6 cells, CCA 800 A) at 25 degC.
/// Defaults are those of docs/physics.md#reference-circuit unless a source is given (#section: of
/// the same page); they are typical values of such blocks, not a fit to one.
struct BatteryParameters {
  double capacity_ah = 50.0;         ///< C_20 [Ah] (paper, section V)
  double inductance_h = 0.15e-6;     ///< L [H]; 0.05 to 1 uH with wiring
  double r_ohmic_ohm = 3.2e-3;       ///< r_i [Ohm]; 2.5 to 5 mOhm
  double r1_charge_ohm = 5.0e-3;     ///< r_1 at small charging currents [Ohm]
  double r1_discharge_ohm = 3.5e-3;  ///< r_1 at small discharging currents [Ohm]
  double r1_knee_current_a = 30.0;   ///< i_x [A], current that halves the share that falls
  double r1_knee_share = 1.0;        ///< of r_1 that falls with current [1]; 0 to 1
  double r1_transition_a = 4.0;      ///< i_w [A], width of the change from discharge to charge
  double r1_transition_at_a = 0.5;   ///< i_s [A], its centre: slightly beside zero current
  double cpe1_exponent = 0.65;       ///< p_1 [1]; 0.55 to 0.8
  double cpe1_corner_hz = 20.0;      ///< where |Z_CPE1| is the mean of the two r_1 [Hz]; 5 to 50 Hz
  double i0_a = 1.0;                 ///< I_0 [A]; 0.3 to 3 A
  double alpha = 0.5;                ///< [1]
  double beta_per_v = 22.0;          ///< [1/V]; 15 to 35
  double cpe2_exponent = 0.88;       ///< p_2 [1]; 0.75 to 1
  double cpe2_capacitance_f = 1000.0;     ///< of the same |Y| at the reference [F]; 500 to 2000
  double cpe2_reference_rad_per_s = 0.3;  ///< [rad/s]
  double u0_v = 12.68;                    ///< u_0 at SOC 0.8 [V]
  double u0_slope_v = 1.35;               ///< du_0/dSOC [V per unit of SOC]; 1.2 to 1.8
  double u_gas_v = 14.1;                  ///< threshold of Fig. 4's gassing branch [V]
  double r_gas_ohm = 0.8;                 ///< its resistance [Ohm]
  double gas_current_a = 0.05;            ///< Tafel law: current at 14.4 V, 25 degC [A] (#gassing)
  double gas_slope_per_v = 1.83;          ///< Tafel law: slope [1/V] (#gassing)
  double gas_slope_per_k = 0.06;          ///< Tafel law: temperature slope [1/K] (#gassing)
  double lead_ion_limit_a = 60.0;      ///< i_lim [A], largest lasting charging current; 20 to 200 A
  double lead_ion_time_s = 15.0;       ///< tau_d [s]; 3 to 40 s (both: #charge_acceptance)
  double r_per_k = -0.006;             ///< relative change of r_i and r_1 [1/K] (#self_heating)
  double activation_j_per_mol = 50e3;  ///< of I_0 [J/mol]; 40 to 60 kJ/mol (#self_heating)
  double lead_ion_halving_k = 15.0;    ///< i_lim halves with every such step down [K]
  double heat_capacity_j_per_k = 13e3;      ///< of the block [J/K]; 12 to 15 kJ/K for 17 kg
  double thermal_resistance_k_per_w = 1.0;  ///< block to surroundings [K/W]; 0.5 to 2
};

constexpr double kReferenceSoc = 0.8;  ///< of u0_v

/// Gives a battery these resistances at 0 A, 0.4 of the smaller one ohmic [Ohm].
void setResistances(BatteryParameters& battery, double r_discharge, double r_charge);

/// How side reactions are described.
enum class GassingLaw {
  kNone,
  kThreshold,  ///< Fig. 4: i_g = max(0, (U_x - u_gas) / r_gas)
  kTafel,      ///< docs/physics.md#gassing: i_g = I_g exp(c_u (U_x - 14.4 V) + c_T (T - 25 degC))
};

/// Which pieces of Fig. 4 act. As default-constructed: all of Fig. 4 and nothing else.
struct BatteryEffects {
  bool inductance = true;             ///< off: L = 0
  bool r1_asymmetry = true;           ///< off: r_1 is the mean of both directions
  bool r1_smooth = true;              ///< off: r_1 changes its value at exactly 0 A
  bool r1_current_dependence = true;  ///< off: the knee current is infinite
  bool cpe1 = true;                   ///< off: nothing beside r_1
  bool cpe1_fractional = true;        ///< off: exponent 1, the same |Z| at the corner
  bool cpe2_fractional = true;        ///< off: exponent 1, the same |Y| at the reference rate
  bool ocv_slope = true;              ///< off: u_0 stays at its value for the first SOC
  GassingLaw gassing = GassingLaw::kThreshold;
  bool charge_acceptance = false;  ///< on: Pb2+ depletion limits charging (not in Fig. 4)
  bool self_heating = false;       ///< on: losses warm the block (not in Fig. 4)
};

/// @return everything off but r_1's two values: the circuit of the paper's Fig. 3.
BatteryEffects plainCircuit();

/// @return CPE1 and CPE2 as the effects leave them.
Cpe cpe1Of(const BatteryParameters& parameters, const BatteryEffects& effects);
Cpe cpe2Of(const BatteryParameters& parameters, const BatteryEffects& effects);

/// @return one sentence for every parameter that is not finite or outside its domain.
std::vector<std::string> faultsOf(const BatteryParameters& parameters);

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

/// Temperature dependence of Fig. 4's elements.
///     r = r_25 (1 + k (T - 25)),           I_0 = I_0,25 exp(E_a/R (1/298.15 - 1/T))
///     i_lim = i_lim,25 2^((T - 25)/15),    I_g = I_g,25 exp(c_T (T - 25))
/// @param temperature [degC], -40 to 80. L, both CPEs, u_0 and the gassing threshold stay.
Conditions atTemperature(const BatteryParameters& parameters, double temperature);

/// Voltage across r_1 and dv/di (paper, III-B; docs/physics.md#reference-circuit).
///     v = r(i) i,   r(i) = [r_1c s + r_1d (1 - s)] / (1 + |i| / i_x)
///     s = 1 / (1 + exp(-(i - i_s) / i_w))
/// @param current through r_1 [A].  @return [V], [Ohm] at 25 degC; at a kink the charging side's.
Linearised r1Voltage(const BatteryParameters& parameters, const BatteryEffects& effects,
                     double current);

/// Eq. 1's exponentials [A]: forward I_0 exp(alpha beta u), backward I_0 exp((alpha - 1) beta u).
struct ReactionRates {
  double forward, backward;
};
ReactionRates reactionRates(const BatteryParameters& parameters, double i0, double u2);

/// Charge-transfer current (paper, eq. 1) at a relative Pb2+ concentration p
/// (docs/physics.md#charge_acceptance; p = 1 is eq. 1 itself).
///     i_r2 = I_0 { p exp(alpha beta u) - exp((alpha - 1) beta u) }
/// @return [A] and its derivative to u2 at constant p [1/Ohm].
Linearised chargeTransfer(const BatteryParameters& parameters, double i0, double u2,
                          double lead_ion);

/// Current of the gassing branch across U_x = u_0 + u_2 [V]: [A], [1/Ohm]; both >= 0.
Linearised gassing(const BatteryParameters& parameters, GassingLaw law, const Conditions& at,
                   double u_x);

/// Open-circuit voltage u_0 = u0_v + u0_slope_v (SOC - 0.8) [V] and its slope [V per unit of SOC].
Linearised openCircuitVoltage(const BatteryParameters& parameters, double soc);

}  // namespace battery_sof_simulator
