#pragma once

#include <Eigen/Core>
#include <functional>

namespace battery_sof {

/// Cost of a least-squares problem with its derivatives at one point, E = sum r^2, J = dr/dx.
struct NormalEquations {
  double cost = 0.0;         ///< r'r
  Eigen::VectorXd gradient;  ///< J'r
  Eigen::MatrixXd hessian;   ///< J'J
};

/// @return what normal equations promise a step away: their quadratic form, the same J.
NormalEquations shifted(NormalEquations at, const Eigen::VectorXd& step);

/// Fills the equations at x; returns false when the model has no finite value there (the step is
/// then refused).
using EvaluateNormalEquations = std::function<bool(const Eigen::VectorXd& x, NormalEquations&)>;

/// How a search or an identification ended; the last four are an identification's alone.
enum class FitStatus {
  kConverged,       ///< the relative step or the relative gain fell below its tolerance
  kIterationLimit,  ///< stopped by the iteration limit, still improving
  kStalled,         ///< no step lowers the cost and the gradient is not small
  kWindowTooShort,  ///< fewer samples than parameters need
  kNotExcited,      ///< the current never changes, or none of the four tunables is determined
  kImplausible,     ///< the search never moved, or its standard errors are none that data can give
  kRefused,  ///< the recording has a problem that has to be corrected first, see findProblems()
};

struct MinimizeOptions {
  int max_iterations = 20;        ///< accepted and refused steps together
  double initial_damping = 1e-3;  ///< relative to the diagonal of J'J
  /// stop when a step promises less than this share of the cost: 0.01 standard errors
  double gain_tolerance = 1e-8;
  /// A step that promises less than this share of the cost, damping at most 0.01 and no bound in
  /// the way, is taken without evaluating its end: MinimizeResult::x is beyond MinimizeResult::at
  /// by last_step then, and at.cost the promised one. 0: never.
  double trusted_gain = 0.0;
  Eigen::VectorXd lower, upper;  ///< hard bounds, empty for none
};

struct MinimizeResult {
  Eigen::VectorXd x;
  NormalEquations at;  ///< at x
  FitStatus status = FitStatus::kConverged;
  int iterations = 0;
  double damping = 0.0;  ///< at the end; lets a search be continued
  /// x minus the point that `at` belongs to; zero unless a step was trusted
  Eigen::VectorXd last_step;
};

/**
 * @brief Minimises E(x) = sum r(x)^2 by Levenberg-Marquardt on normal equations, inside a box.
 *
 *     (J'J + lambda diag(J'J)) step = -J'r,    coordinates held at a bound that the step would cross are left out
 *
 * @param start inside the box; evaluate must succeed there.
 * @throws std::invalid_argument when it does not.
 * @see Marquardt 1963; paper, section IV and its reference [19].
 */
MinimizeResult minimize(const EvaluateNormalEquations& evaluate, const Eigen::VectorXd& start,
                        const MinimizeOptions& options);

}  // namespace battery_sof
