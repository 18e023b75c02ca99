#pragma once

#include <optional>
#include <string>

namespace battery_sof {

/// One estimated parameter.
struct ParameterEstimate {
  std::string name;    ///< as in BatteryModel::parameters()
  std::string unit;    ///< ohm, F, 1/V, V, ...
  double value = 0.0;  ///< in unit
  /// standard error in unit; none when nothing is known: not excited, or held at a bound
  std::optional<double> std;
  bool at_bound = false;  ///< ended at (or in the penalty beyond) a bound
  /// standard error below half the value (below 0.5 V for u_dc), and not at a bound
  bool determined = true;
  bool held = false;  ///< not estimated: stays where EffectInfo or the caller put it
};

}  // namespace battery_sof
