#pragma once

#include <Eigen/Core>
#include <complex>

namespace battery_sof_simulator {

/// A constant phase element (paper, eq. 2): Z(jw) = A (jw)^-p, with A = 1 / scale. exponent 1 is a
/// capacitor of `scale` farad; scale 0 is an open circuit.
struct Cpe {
  double scale = 0.0;     ///< 1 / A [A s^p / V], >= 0
  double exponent = 1.0;  ///< p [1], in (0, 1]
};

/// @return (jw)^p * scale, the admittance of the element itself [1/Ohm]. @param omega [rad/s], > 0.
std::complex<double> analyticAdmittance(const Cpe& cpe, double omega);

/// Voltages inside a ladder [V]. All zero: the element has rested for ever.
struct LadderState {
  using Branches = Eigen::Array<double, Eigen::Dynamic, 1, 0, 32, 1>;
  double voltage = 0.0;  ///< across the element
  Branches branches;     ///< across each branch's capacitor
};

/// A CPE as a passive ladder: a capacitor beside series RC branches
/// (docs/physics.md#constant-phase-element, Foster form).
///     s^p = (sin(p pi) / pi) int_0^inf w^(p-1) s / (s + w) dw,   0 < p < 1
///     i = C du/dt + sum_k g_k (u - v_k),     dv_k/dt = w_k (u - v_k)
/// The integral is summed over two rates w_k a decade from 1e-5 to 1e5 rad/s; what lies above
/// becomes the capacitor, what lies below one more branch at its centre of gravity. Every element
/// is positive, so the ladder stores and dissipates but never generates energy. The impedance is
/// within 0.2 % of the analytic one from 1 mHz to 100 Hz and within 1 % at 1 kHz, for 0.5 <= p <= 1
/// (a test holds this). Memory reaches back a day.
class CpeLadder {
 public:
  /// @param step that advance() moves by [s], > 0.
  /// @throws std::invalid_argument for a scale below 0 or an exponent outside (0, 1].
  explicit CpeLadder(const Cpe& cpe, double step = 0.001);

  LadderState rested() const { return settled(0.0); }
  /// After a long time at a voltage [V].
  LadderState settled(double voltage) const {
    return {voltage, LadderState::Branches::Constant(rate_.size(), voltage)};
  }
  std::complex<double> admittance(double omega) const;  ///< [1/Ohm], omega > 0 [rad/s]
  double storedEnergy(const LadderState& s) const {     ///< [J], >= 0
    return 0.5 * capacitance_ * s.voltage * s.voltage +
           0.5 * (conductance_ / rate_ * s.branches.square()).sum();
  }
  double dissipation(const LadderState& s) const {  ///< [W], >= 0
    return (conductance_ * (s.voltage - s.branches).square()).sum();
  }

  /// One implicit Euler step: at its end the current is conductance() * u - sourceCurrent(before),
  /// linear in the end voltage u, the branches being eliminated; advance() fills them in.
  double conductance() const { return total_; }            ///< [1/Ohm]
  double sourceCurrent(const LadderState& before) const {  ///< [A]
    return capacitance_ / step_ * before.voltage + (step_conductance_ * before.branches).sum();
  }
  LadderState advance(const LadderState& before, double voltage) const {
    return {voltage, before.branches + share_ * (voltage - before.branches)};
  }

 private:
  double step_;                             // [s]
  double capacitance_ = 0.0;                // [F]
  double total_;                            // [1/Ohm]
  LadderState::Branches rate_;              // w_k [rad/s]
  LadderState::Branches conductance_;       // g_k [1/Ohm]
  LadderState::Branches step_conductance_;  // g_k with the branch eliminated [1/Ohm]
  LadderState::Branches share_;             // weight of the end voltage in a branch's new voltage
};

}  // namespace battery_sof_simulator
