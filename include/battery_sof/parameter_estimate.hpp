#pragma once

#include <optional>
#include <string>

namespace battery_sof {

/// One estimated parameter.
struct ParameterEstimate {
  std::string name;    ///< as in BatteryModel::parameters()
  std::string unit;    ///< ohm, F, 1/V, V, ...
  double value = 0.0;  ///< in unit
  /// standard error in unit; none if it is not known: not excited, or at a bound
  std::optional<double> std;
  bool at_bound = false;  ///< the search ended at a bound, or in the penalty beyond it
  /// standard error below half the value (below 0.5 V for u_dc), and not at a bound
  bool determined = true;
  bool held = false;  ///< not estimated: keeps the value of EffectInfo or of the caller
};

}  // namespace battery_sof
