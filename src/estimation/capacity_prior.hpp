#pragma once

#include <Eigen/Core>
#include <optional>

#include "estimation/parameter_space.hpp"

namespace battery_sof {

/// What a full block at rest has, of whatever make [V].
inline constexpr double kFullVoltage = 12.9, kFullSpread = 0.1;

/**
 * @brief What the nominal capacity says of where a discharge ends.
 *
 *     z = (U_full - U_E - c k_s Q (1 + theta / 20 h)) / s,   z ~ N(0, 1),   c = 0.95,  s = 0.2 V
 *
 * A full battery from which c Q is drawn in the 20 h of the nominal capacity Q [Ah] has come to
 * U_E, with k_s of ocv_slope and U_E and theta of end_of_discharge (docs/physics.md#end_of_discharge).
 * s holds what batteries in use give of Q (0.12 of it, which are 0.18 V) and kFullSpread.
 */
class CapacityPrior {
 public:
  /// @param capacity [Ah], nominal.  @return none for a model without end_of_discharge.
  static std::optional<CapacityPrior> of(const BatteryModel& model, double capacity);

  struct Residual {
    double z = 0.0;
    Eigen::VectorXd slopes;  ///< by the coordinates
  };
  /// @param x coordinates of the space.
  Residual at(const ParameterSpace& space, const Eigen::VectorXd& x) const;

 private:
  Eigen::Index slope_, end_, delay_;  // rows of k_s, U_E and theta
  double capacity_;                   // Q [Ah]
};

}  // namespace battery_sof
