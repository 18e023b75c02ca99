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
  bool held = false;  ///< stays at its magnitude
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

/// Voltage across the double layer and its derivatives to what it depends on.
struct Overpotential {
  double value = 0.0;      ///< u_c2 [V]
  double d_initial = 1.0;  ///< d u_c2 / d u_c2(start) [1]
  double d_c2 = 0.0;       ///< d u_c2 / d C_2 [V/F]
  double d_beta = 0.0;     ///< d u_c2 / d beta [V^2]
};

}  // namespace battery_sof
