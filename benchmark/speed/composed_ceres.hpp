#pragma once

#include "estimation/composition_fit.hpp"

namespace battery_sof_bench {

/// Where Ceres ended.
struct CeresEnd {
  Eigen::VectorXd x;    ///< in the coordinates of the problem it was given
  int residuals = 0;    ///< passes for values alone
  int jacobians = 0;    ///< passes with derivatives
  std::string message;  ///< Ceres' own
};

/// How Ceres solves for a step.
enum class CeresAlgebra { kQr, kNormalCholesky };

/**
 * @brief Minimises what CompositionProblem does for composedModel(), derivatives by Ceres' Jets,
 * one thread.
 *
 * The model is written down a second time, as one would for Ceres alone: one cost function over the
 * whole drive, lead ions and double layer by an implicit Euler step extrapolated to second order
 * under the same step control, acid by exact exponentials. Newton's method of a step runs in
 * doubles, one last step of it in Jets. Same coordinates, bounds, priors and weights as `problem`;
 * Ceres' default tolerances.
 *
 * @param problem of composedModel() over `drive`, without a noise model.  @param start in its
 * coordinates.
 * @throws std::runtime_error when Ceres ends without a usable solution.
 */
CeresEnd fitComposedWithCeres(const battery_sof::BatteryModel& model,
                              const battery_sof::CompositionProblem& problem,
                              const battery_sof::InputSequence& inputs,
                              const Eigen::VectorXd& start, CeresAlgebra algebra);

}  // namespace battery_sof_bench
