#include "regression/levenberg_marquardt.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace battery_sof {
namespace {

// Damping beyond which the step is below rounding: nothing lowers the cost from here.
constexpr double kHopelessDamping = 1e16;
// Damping below which a step is the undamped one to a per cent.
constexpr double kGentleDamping = 1e-2;
constexpr double kTiny = 1e-9;  // of |x|: a step that ends the search

/// Coordinates that may move: not at a bound which the gradient pushes against.
std::vector<int> freeCoordinates(const Eigen::VectorXd& x, const Eigen::VectorXd& gradient,
                                 const MinimizeOptions& options) {
  std::vector<int> free;
  for (int j = 0; j < x.size(); ++j) {
    const bool at_lower = options.lower.size() > 0 && x[j] <= options.lower[j] && gradient[j] > 0.0;
    const bool at_upper = options.upper.size() > 0 && x[j] >= options.upper[j] && gradient[j] < 0.0;
    if (!at_lower && !at_upper) free.push_back(j);
  }
  return free;
}

Eigen::VectorXd dampedStep(const NormalEquations& at, const std::vector<int>& free, double lambda) {
  Eigen::MatrixXd A = at.hessian(free, free);
  const double floor = 1e-30 + 1e-12 * at.hessian.diagonal().maxCoeff();
  A.diagonal() += lambda * A.diagonal().cwiseMax(floor);
  Eigen::VectorXd step = Eigen::VectorXd::Zero(at.gradient.size());
  step(free) = -A.ldlt().solve(at.gradient(free));
  return step;
}

Eigen::VectorXd projected(const Eigen::VectorXd& x, const MinimizeOptions& options) {
  Eigen::VectorXd inside = x;
  if (options.lower.size() > 0) inside = inside.cwiseMax(options.lower);
  if (options.upper.size() > 0) inside = inside.cwiseMin(options.upper);
  return inside;
}

/**
 * @brief Damping after Nielsen (1999, IMM-REP-1999-05).
 *
 * A step whose real gain is rho times the predicted one changes it by
 *
 *     rho > 0:   lambda <- lambda max(1/3, 1 - (2 rho - 1)^3),  nu <- 2
 *     rho <= 0:  lambda <- lambda nu,                            nu <- 2 nu
 */
struct Damping {
  double lambda;
  double growth = 2.0;  // nu

  void accept(double gain_ratio) {
    lambda *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain_ratio - 1.0, 3));
    growth = 2.0;
  }
  void reject() {
    lambda *= growth;
    growth *= 2.0;
  }
};

/// The loop of minimize(); result holds a valid start.
void search(const EvaluateNormalEquations& evaluate, const MinimizeOptions& options,
            Damping& damping, MinimizeResult& result) {
  NormalEquations trial;
  for (result.iterations = 0; result.iterations < options.max_iterations; ++result.iterations) {
    const auto free = freeCoordinates(result.x, result.at.gradient, options);
    if (free.empty()) return;
    const Eigen::VectorXd wanted = result.x + dampedStep(result.at, free, damping.lambda);
    const Eigen::VectorXd x = projected(wanted, options);
    const Eigen::VectorXd step = x - result.x;
    // fall of the cost by the linearised residual
    const double promised = -(2.0 * result.at.gradient + result.at.hessian * step).dot(step);
    const bool cut = x != wanted;  // a bound was in the way
    const bool tiny = step.norm() <= kTiny * (result.x.norm() + 1e-12);
    const bool nothing_to_gain = tiny || promised <= options.gain_tolerance * result.at.cost;
    if (damping.lambda <= 1.0 && nothing_to_gain && !cut) return;
    if (damping.lambda <= kGentleDamping && promised <= options.trusted_gain * result.at.cost &&
        !cut) {
      result.last_step = step;
      result.x = x;
      result.at.cost -= promised;
      return;
    }
    const bool finite = promised > 0.0 && evaluate(x, trial) && std::isfinite(trial.cost);
    const double gain = finite ? result.at.cost - trial.cost : -1.0;
    if (gain > 0.0) {
      result.x = x;
      std::swap(result.at, trial);
      damping.accept(gain / std::max(promised, 1e-300));
    } else {
      damping.reject();
      if (damping.lambda > kHopelessDamping || (tiny && !cut)) {
        result.status = FitStatus::kStalled;
        return;
      }
    }
  }
  result.status = FitStatus::kIterationLimit;
}

}  // namespace

NormalEquations shifted(NormalEquations at, const Eigen::VectorXd& step) {
  const Eigen::VectorXd curved = at.hessian * step;
  at.cost += (2.0 * at.gradient + curved).dot(step);
  at.gradient += curved;
  return at;
}

MinimizeResult minimize(const EvaluateNormalEquations& evaluate, const Eigen::VectorXd& start,
                        const MinimizeOptions& options) {
  MinimizeResult result;
  result.x = projected(start, options);
  if (!evaluate(result.x, result.at) || !std::isfinite(result.at.cost))
    throw std::invalid_argument("minimize: the cost has no finite value at the start");
  result.last_step = Eigen::VectorXd::Zero(start.size());
  Damping damping{options.initial_damping};
  search(evaluate, options, damping, result);
  result.damping = damping.lambda;
  return result;
}

}  // namespace battery_sof
