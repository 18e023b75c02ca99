#pragma once

#include <array>
#include <string>
#include <vector>

#include "simulator/filters.hpp"

namespace battery_sof_simulator {

/// What parameter_drift changes.
enum class DriftingParameter { kROhmic, kR1, kCpe2Capacitance, kU0 };

/// Pieces of physics that Fig. 4 does not have, each off unless its switch is on. Numbers are
/// typical values for a 12 V, 50 Ah VRLA block (docs/physics.md); i is positive into the battery,
/// (x)+ is max(x, 0), LP_tau a first-order low-pass. All voltages lie in series with Fig. 4's. The
/// last six describe batteries that no catalogue of effects lists.
struct Additions {
  /// S5: C_3 || charge transfer, i = CPE_3(u_3) + 2 I_03 sinh(beta_3 u_3 / 2); voltage u_3.
  bool second_electrode = false;
  double electrode3_capacitance_f = 2500.0;  ///< of the same |Y| at cpe2_reference_rad_per_s [F]
  double electrode3_exponent = 1.0;          ///< p_3 [1]; 1: a capacitor
  double electrode3_i0_a = 1.0;              ///< I_03 [A]
  double electrode3_beta_per_v = 40.0;       ///< beta_3 [1/V]
  /// S2: tau_h dv/dt = R_h i - v; voltage v.
  bool fast_arc = false;
  double fast_arc_ohm = 1e-3;    ///< R_h [Ohm]
  double fast_arc_time_s = 0.1;  ///< tau_h [s]
  /// P4: tau_j dw_j/dt = R_j i - w_j, j = 1, 2; voltage w_1 + w_2.
  bool acid_transport = false;
  double acid_1_ohm = 2e-3;      ///< R_1 [Ohm]
  double acid_1_time_s = 60.0;   ///< tau_1 [s]
  double acid_2_ohm = 3e-3;      ///< R_2 [Ohm]
  double acid_2_time_s = 600.0;  ///< tau_2 [s]
  /// P6: dh/dt = |i| (sgn i - h) / Q_h; voltage M h.
  bool ocv_hysteresis = false;
  double hysteresis_v = 0.02;   ///< M [V]
  double hysteresis_ah = 0.25;  ///< Q_h [Ah]
  /// P7: x = LP_tau[(-i)+ / i_L]; voltage kappa ln(1 - x), x held below 0.99.
  bool high_rate_depletion = false;
  double depletion_v = 0.15;         ///< kappa [V]
  double depletion_limit_a = 400.0;  ///< i_L [A]
  double depletion_time_s = 30.0;    ///< tau [s]
  /// P8: voltage -U_cf (1 - n) y,  dn/dt = (-i)+ (1 - n) / Q_n - (i)+ n / Q_e,
  ///     dy/dt = (-i)+ (1 - y) / Q_r - (i)+ y / Q_r.
  bool coup_de_fouet = false;
  double coup_v = 0.1;                ///< U_cf [V]
  double coup_onset_ah = 0.02;        ///< Q_r [Ah]
  double coup_nuclei_ah = 0.3;        ///< Q_n [Ah]
  double coup_erasing_ah = 0.5;       ///< Q_e [Ah]
  double coup_nuclei_at_start = 1.0;  ///< n at the start [1]; 0: fully charged
  /// P3: i_lim = i_lim0 A, dA/dt = ((-i)+ - chi (i)+) / Q_A - (A - 1) / tau_r, A >= A_min; with
  /// charge_acceptance only.
  bool sulphate_history = false;
  double sulphate_ah = 0.5;            ///< Q_A [Ah]
  double sulphate_time_s = 1200.0;     ///< tau_r [s]
  double sulphate_charge_share = 0.6;  ///< chi [1]
  double sulphate_least = 0.2;         ///< A_min [1]
  /// P12 by the surface of crystals, which dissolve (after Thele and others), in place of the
  /// effect's own law: i_lim = i_lim0 (1 + k N^(1/3) Q^(2/3)), Q [Ah] fresh sulphate, N [1] its
  /// crystals; dQ/dt = -i, Q >= 0; dN/dt = (-i)+ / Q_N - N / tau_o, and while charging N falls as Q
  /// does. With charge_acceptance only.
  bool sulphate_crystals = false;
  double crystal_supply = 120.0;       ///< k [Ah^(-2/3)]
  double crystal_nuclei_ah = 0.02;     ///< Q_N, the charge that makes one unit of crystals [Ah]
  double crystal_ripening_s = 1800.0;  ///< tau_o [s]
  /// P10: one parameter times 1 + rate t.
  bool parameter_drift = false;
  DriftingParameter drifting = DriftingParameter::kROhmic;
  double drift_per_h = 0.1;  ///< rate [1/h]
  /// P11: a load that the current sensor does not see, also on in the rest before the start [A].
  double parasitic_load_a = 0.0;
  /// I6: a resistance more from an instant on.
  bool contact_step = false;
  double contact_ohm = 5e-4;
  double contact_from_s = 600.0;
  /// Voltage r_m LP_tau[|i|] i.
  bool memory_resistance = false;
  double memory_ohm_per_a = 1e-4;  ///< r_m [Ohm/A]
  double memory_time_s = 20.0;     ///< tau [s]
  /// Voltage sgn(i) U_s while |i| is above a threshold.
  bool step_force = false;
  double step_force_v = 0.1;         ///< U_s [V]
  double step_force_above_a = 60.0;  ///< [A]
  /// Voltage U_t g sin(2 pi t / T), g = LP_2s[1 while |i| is above 5 A, else 0].
  bool gated_tone = false;
  double gated_tone_v = 0.02;         ///< U_t [V]
  double gated_tone_period_s = 40.0;  ///< T [s]
  /// CPE2's scale times (1 - share)^(t / 1 h).
  bool capacitance_fall = false;
  double capacitance_fall_share = 0.6;  ///< lost within an hour [1]
  /// No charge transfer while |u_2| is below a threshold; beyond it eq. 1 of the rest.
  bool dead_zone = false;
  double dead_zone_v = 0.01;  ///< [V]
  /// r_i plus s R, s the sign of the last current above a threshold (0 before the first).
  bool hysteretic_r = false;
  double hysteretic_ohm = 1e-3;     ///< R [Ohm]
  double hysteretic_from_a = 20.0;  ///< [A]
};

/// @return whether any of them is on.
bool anyOn(Additions additions);

/// What the additions remember.
struct AddedState {
  std::array<double, 3> rc{};    ///< v, w_1, w_2 [V]
  double hysteresis = 0.0;       ///< h [1]
  double depletion = 0.0;        ///< x [1]
  double nuclei = 1.0;           ///< n [1]
  double onset = 0.0;            ///< y [1]
  double sulphate = 1.0;         ///< A [1]
  double fresh_ah = 0.0;         ///< Q of the crystals [Ah]
  double crystals = 0.0;         ///< N [1]
  double remembered = 0.0;       ///< LP[|i|] [A]
  double gate = 0.0;             ///< g [1]
  double last_large_sign = 0.0;  ///< s: -1, 0 or 1
};

/// The additions that follow from the battery's current alone. Low-passes are moved exactly for a
/// current that is linear over a step, the products of current and state exactly for its mean. What
/// is off keeps its value and adds nothing.
class AddedVoltages {
 public:
  /// @param step over which advance() moves [s], > 0.
  AddedVoltages(const Additions& additions, double step);

  /// @return the state after a long time under a small steady current [A].
  AddedState settled(double current) const;
  AddedState advance(const AddedState& before, double begin, double end) const;

  /// Added voltage without those that are resistances or u_3 [V]. @param time since start [s].
  double voltage(const AddedState& state, double time, double current) const;
  /// What i_lim is multiplied by [1].
  double chargeLimitFactor(const AddedState& state) const;
  /// What is added to r_i [Ohm].
  double resistance(const AddedState& state, double time) const;

 private:
  Additions additions_;
  double step_;
  std::array<double, 3> rc_ohm_;  // of fast_arc and acid_transport, 0 where off
  std::array<LowPass, 3> rc_;
  LowPass depletion_, memory_, gate_;
};

}  // namespace battery_sof_simulator
