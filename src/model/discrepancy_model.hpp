#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/effect.hpp"
#include "model/regressors.hpp"

namespace battery_sof {

/// Directions of the base circuit: r_discharge, r_charge, ln c2, ln beta, u_dc, first u_c2.
constexpr Eigen::Index kBaseDirections = 6;

/// Id of the effect that a discrepancy model is in a composition.
inline const std::string kDiscrepancyEffect = "discrepancy";

/**
 * @brief A voltage in series with the battery that was estimated where no equation represents it.
 *
 *     u = u_m + S d + sum_f a_f sum_(k of f) w_k (x_k - centre_k) / scale_k
 *
 * x_k: regressors of the inputs and of the double layer's voltage, held inside what was estimated
 * on; a_f: one factor a mechanism, the effect's parameters, 1 as estimated; S d: what the circuit's
 * directions answer to its change d with the discrepancy, along the linearised double layer
 *
 *     C_2 ds/dt = -G s - C_2 (du_c2/dt) d ln c2 - G u_c2 d ln beta,   G = d i_r2 / d u_c2
 *
 * A large change of the circuit in its place would leave the region in which discrepancy and
 * circuit were estimated together.
 */
struct DiscrepancyModel {
  /// What is estimated of one mechanism's part as a whole.
  struct Part {
    Mechanism mechanism;
    double std = 0.1;  ///< [1], of a_f
  };
  std::vector<Regressor> regressors;
  RegressorContext context;
  /// of the training part, in the regressors' units; a regressor is held inside
  Eigen::VectorXd lower, upper;
  /// mean and RMS about it over the training part, in the regressors' units
  Eigen::VectorXd centre, scale;
  Eigen::VectorXd weight;  ///< [V], of regressors of unit RMS
  /// of weight, where it was estimated [V^2]; empty: not known. Files do not hold it
  Eigen::MatrixXd covariance;
  Eigen::VectorXd base_change;  ///< d [Ohm, Ohm, 1, 1, V, V]
  std::vector<Part> parts;      ///< one a mechanism that has regressors

  /// Numbers of its memory: see Simulation::regressorMemory().
  std::size_t memorySize() const;
  /// A regressor's value as it is used: inside its range, but for isUnbounded().
  double used(Eigen::Index regressor, double value) const;
};

/// Whether a regressor is used beyond the range it was estimated on: charge counted goes on.
bool isUnbounded(RegressorKind kind);

/// @return the discrepancy as an effect of a composition: a parameter a mechanism, no state.
/// @throws std::invalid_argument for sizes that do not fit, numbers that are not finite, scales not
///   above zero, ranges that do not rise, or a regressor of a mechanism without a part.
EffectInfo discrepancyInfo(const DiscrepancyModel& discrepancy);

/// @return the memory after a rest that is long against every time constant below an hour.
std::vector<double> restedMemory(const DiscrepancyModel& discrepancy, std::vector<double> memory);

}  // namespace battery_sof
