#pragma once

#include <array>
#include <optional>
#include <string>

namespace battery_sof {

/// Parameters of the base model (paper, Fig. 3 and Table I). All finite; all but u_dc above zero;
/// alpha below one.
struct BaseParameters {
  double r_discharge = 0.008;  ///< r_-   [Ohm], ohmic resistance while discharging
  double r_charge = 0.010;     ///< r_+   [Ohm], ohmic resistance while charging
  double c2 = 1000.0;          ///< C_2   [F], double-layer capacitance
  double beta = 20.0;          ///< beta  [1/V], slope of the Butler-Volmer relation
  double u_dc = 12.0;          ///< u_dc  [V], open-circuit voltage of the window
  double i0 = 1.0;             ///< I_0   [A], exchange current
  double alpha = 0.5;          ///< alpha [1], symmetry of the charge transfer, in (0, 1)
};

/// What is known of a parameter before anything was measured.
struct ParameterInfo {
  std::string name;    ///< code name, as in JSON and YAML
  std::string symbol;  ///< the paper's
  std::string unit;    ///< "ohm", "F", "1/V", "V", "A", "1"
  double magnitude;    ///< order of magnitude and start value, in unit
  double lower;        ///< bound, in unit
  double upper;        ///< bound, in unit
  std::string source;
  bool logarithmic = false;  ///< searched as a logarithm: what counts is its order of magnitude
  /// the voltage is linear in it while the others stay; see EffectInfo::is_nonlinear
  bool linear = false;
  /// a time of the recording: bounded by it, and fits start from several
  bool instant = false;
  bool held = false;  ///< stays at its magnitude unless it is set free by name
  /// Standard deviation of what is known beforehand around the magnitude: in unit, of the logarithm
  /// when logarithmic.
  std::optional<double> prior_std = std::nullopt;
  /// Value at which the effect that owns the parameter vanishes; none for parameters that only
  /// shape it.
  std::optional<double> vanishes_at = std::nullopt;
};

/// @return r_discharge, r_charge, c2, beta with magnitudes and bounds of the paper's Table I.
const std::array<ParameterInfo, 4>& tableOne();

/// @throws std::invalid_argument when a parameter is not finite or outside its domain; the message
/// names it and its value.
void requireValid(const BaseParameters& parameters);

/// @return r_discharge for current < 0, r_charge otherwise [Ohm].
double ohmicResistance(const BaseParameters& parameters, double current);

/**
 * @brief Charge-transfer current of the base model (paper, eq. 1).
 *
 *     i_r2(u) = I_0 { exp(alpha beta u) - exp((alpha - 1) beta u) }
 *
 * @param u_c2 voltage across the double layer [V].
 * @return current [A], positive for positive u_c2; infinite when the exponent overflows.
 */
double chargeTransferCurrent(const BaseParameters& parameters, double u_c2);

/**
 * @brief Terminal voltage of the base model at one instant (paper, Fig. 3).
 *
 *     u = u_dc + r(i) i + u_c2,     r(i) = r_charge for i >= 0, r_discharge for i < 0
 *
 * @param current battery current [A], positive while charging.
 * @param u_c2    voltage across the double-layer capacitor [V].
 * @return terminal voltage [V]; continuous in current, not differentiable at 0.
 * @note Gassing and charge-acceptance limits are not modelled here; diagnose/ is there to find
 * them.
 */
double terminalVoltage(const BaseParameters& parameters, double current, double u_c2);

/**
 * @brief Voltage across the double layer that a held current settles at: i_r2(u) = i.
 * @return u_c2 [V]; closed form (2/beta) asinh(i / (2 I_0)) for alpha = 0.5, Newton's method
 * otherwise.
 */
double settledOverpotential(const BaseParameters& parameters, double current);

/// Voltage across the double layer and its derivatives to what it depends on.
struct Overpotential {
  double value = 0.0;      ///< u_c2 [V]
  double d_initial = 1.0;  ///< d u_c2 / d u_c2(start) [1]
  double d_c2 = 0.0;       ///< d u_c2 / d C_2 [V/F]
  double d_beta = 0.0;     ///< d u_c2 / d beta [V^2]
};

/**
 * @brief Step of the base model's only state under a current held over an interval.
 *
 *     C_2 du_c2/dt = i - i_r2(u_c2)                                            (paper, Fig. 3 and eq. 1)
 *
 * alpha = 0.5: exact. With E = exp(beta u / 2) the equation is a Riccati equation; its step is the
 * symmetric linear map of ClosedFormStep, in which every term is positive, so nothing cancels and
 * no step is unstable (docs/physics.md#base-circuit: the same step as tanh). alpha != 0.5: SDIRK of
 * order 2, L-stable (Alexander 1977), with step control to 1e-6 V a step.
 *
 * Beyond |beta u / 2| = 300 the state is taken at that value: the branch empties it within a
 * microsecond.
 */
class OverpotentialStep {
 public:
  /// @throws std::invalid_argument as requireValid().
  explicit OverpotentialStep(const BaseParameters& parameters);

  /**
   * @param u_c2    state before [V].   @param current held current [A].   @param dt interval [s], >= 0.
   * @return state after [V].
   */
  double advance(double u_c2, double current, double dt) const;

  /// As above, with the derivatives carried along (forward sensitivities of the very step that is
  /// taken).
  Overpotential advance(const Overpotential& before, double current, double dt) const;

 private:
  Overpotential advanceClosedForm(const Overpotential& before, double current, double dt) const;
  Overpotential advanceImplicit(const Overpotential& before, double current, double dt) const;

  BaseParameters parameters_;
};

}  // namespace battery_sof
