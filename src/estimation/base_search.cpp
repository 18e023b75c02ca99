#include "estimation/base_search.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/fit_quality.hpp"
#include "estimation/parameter_space.hpp"
#include "regression/levenberg_marquardt.hpp"

namespace battery_sof {
namespace {

// The first state is searched inside +-2 V: a 12 V block's overpotential stays below 1 V in any
// use.
constexpr double kMaxFirstState = 2.0;
constexpr double kPenaltySteepness = 10.0;
// Windows longer than this are first approached on averages of kCoarseFactor samples.
constexpr std::size_t kCoarseFrom = 4000;
constexpr std::size_t kCoarseFactor = 20;
// Share of the cost below which a last step needs no second look, see searchWindow().
constexpr double kTrustedGain = 1e-5;

/// r_discharge, r_charge, u_dc - offset at a point of the search, and which of them are free.
struct LinearSolution {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  std::array<bool, 3> free = {true, true, true};
  double cost = std::numeric_limits<double>::infinity();
};

/// Solves for the free linear parameters with the others held at value.
LinearSolution solveFree(const BaseSums& sums, LinearSolution solution) {
  const Eigen::Matrix3d G = sums.topLeftCorner<3, 3>();
  const Eigen::Vector3d target = sums.col(kColumnTarget).head<3>();
  Eigen::Matrix3d A = G;
  Eigen::Vector3d b = target;
  for (int j = 0; j < 3; ++j) {
    if (solution.free[j]) continue;
    b -= G.col(j) * solution.value[j];
    A.row(j).setZero();
    A.col(j).setZero();
    A(j, j) = 1.0;
    b[j] = 0.0;
  }
  const Eigen::Vector3d solved = A.ldlt().solve(b);
  for (int j = 0; j < 3; ++j)
    if (solution.free[j]) solution.value[j] = solved[j];
  solution.cost = sums(kColumnTarget, kColumnTarget) - 2.0 * target.dot(solution.value) +
                  solution.value.dot(G * solution.value);
  return solution;
}

bool insideBounds(const LinearSolution& solution) {
  for (int j = 0; j < 2; ++j) {
    const auto& info = tableOne()[j];
    if (solution.value[j] < info.lower || solution.value[j] > info.upper) return false;
  }
  return true;
}

/// Least squares in the linear parameters inside their bounds: at most nine cases of free, lower
/// and upper.
LinearSolution solveLinear(const BaseSums& sums, const std::array<double, 4>& initial) {
  LinearSolution start;
  for (int j = 0; j < 2; ++j) {
    start.free[j] = sums(j, j) > 0.0;
    start.value[j] = initial[j];
  }
  LinearSolution unbounded = solveFree(sums, start);
  if (insideBounds(unbounded)) return unbounded;
  LinearSolution best;
  for (int choice = 1; choice < 9; ++choice) {
    LinearSolution trial = start;
    const std::array<int, 2> side = {choice % 3, choice / 3};
    for (int j = 0; j < 2; ++j) {
      if (side[j] == 0) continue;
      trial.free[j] = false;
      trial.value[j] = side[j] == 1 ? tableOne()[j].lower : tableOne()[j].upper;
    }
    trial = solveFree(sums, trial);
    if (insideBounds(trial) && trial.cost < best.cost) best = trial;
  }
  return best;
}

/// Normal equations of (ln c2, ln beta, first state) after the free linear parameters are
/// eliminated.
void eliminate(const BaseSums& sums, const LinearSolution& linear, NormalEquations& reduced) {
  const Eigen::Matrix3d S = sums.block<3, 3>(kColumnLogC2, kColumnLogC2);
  const Eigen::Matrix3d cross = sums.block<3, 3>(0, kColumnLogC2);
  reduced.cost = std::max(linear.cost, 0.0);
  reduced.gradient =
      -(sums.col(kColumnTarget).segment<3>(kColumnLogC2) - cross.transpose() * linear.value);
  Eigen::Matrix3d G = sums.topLeftCorner<3, 3>();
  Eigen::Matrix3d projected = cross;
  for (int j = 0; j < 3; ++j) {
    if (linear.free[j]) continue;
    G.row(j).setZero();
    G.col(j).setZero();
    G(j, j) = 1.0;
    projected.row(j).setZero();
  }
  reduced.hessian = S - projected.transpose() * G.ldlt().solve(projected);
}

/// Moves the linear parameters along with a step of (ln c2, ln beta, first state), by the normal
/// equations at its start.
void follow(const BaseSums& sums, const Eigen::Vector3d& step, LinearSolution& linear) {
  LinearSolution moved = linear;
  BaseSums after = sums;
  after.col(kColumnTarget).head<3>() -= sums.block<3, 3>(0, kColumnLogC2) * step;
  moved = solveFree(after, moved);
  if (insideBounds(moved)) linear = moved;
}

/// ln c2, ln beta and the first state [V].
const std::array<FitCoordinate, 3>& searched() {
  static const std::array<FitCoordinate, 3> all = [] {
    std::array<FitCoordinate, 3> space;
    for (std::size_t k = 0; k < 2; ++k) {
      space[k].logarithmic = true;
      space[k].lower = tableOne()[k + 2].lower;
      space[k].upper = tableOne()[k + 2].upper;
    }
    space[2].lower = -kMaxFirstState;
    space[2].upper = kMaxFirstState;
    return space;
  }();
  return all;
}

OverpotentialSweep::Point pointOf(const Eigen::VectorXd& x) {
  return {searched()[0].value(x[0]), searched()[1].value(x[1]), searched()[2].value(x[2])};
}

/// Residual (exp(10 d) - 1) V for a relative excess d beyond a bound, and its slope to the
/// normalised parameter.
struct Penalty {
  double residual = 0.0;
  double slope = 0.0;
};

Penalty penaltyOf(const ParameterInfo& info, double value) {
  const bool below = value < info.lower;
  if (!below && value <= info.upper) return {};
  const double bound = below ? info.lower : info.upper;
  // The exponent is capped where the cost is already beyond any sum of squares of voltages.
  const double excess = std::min((below ? bound - value : value - bound) / bound, 10.0);
  const double growth = std::exp(kPenaltySteepness * excess);
  return {growth - 1.0, (below ? -1.0 : 1.0) * kPenaltySteepness * growth * info.magnitude / bound};
}

/// A window as the paper's search sees it.
struct PaperWindow {
  BaseNormalEquations weighted, unweighted;  // eq. 3; eq. 4
  FirstSample first;
};

/// What a point means in the paper's search: u_dc of eq. 4 with the normal equations of eq. 3.
struct PaperPoint {
  std::array<double, 4> theta{};
  OverpotentialSweep::Point point;
  double u_dc = 0.0;
  NormalEquations equations;
};

PaperPoint evaluateAsInPaper(const PaperWindow& window, double u_dc_before,
                             const Eigen::VectorXd& x) {
  PaperPoint p;
  for (int j = 0; j < 4; ++j) p.theta[j] = x[j] * tableOne()[j].magnitude;
  const FirstSample& first = window.first;
  const double r = first.current < 0.0 ? p.theta[0] : p.theta[1];
  // Beyond the bounds the penalty decides; the simulation only has to stay defined there.
  p.point = {std::max(p.theta[2], 1e-3 * tableOne()[2].lower),
             std::max(p.theta[3], 1e-3 * tableOne()[3].lower),
             first.voltage - r * first.current - u_dc_before};  // eq. 5
  const BaseSums sums = window.weighted.sums(p.point);

  // Columns of d u_ac / d x and of u_b - u_ac as combinations of the pass's columns.
  Eigen::Matrix<double, kBaseColumns, 4> T = Eigen::Matrix<double, kBaseColumns, 4>::Zero();
  T(kColumnDischarge, 0) = T(kColumnCharge, 1) = 1.0;
  T(kColumnInitial, first.current < 0.0 ? 0 : 1) = -first.current;
  T(kColumnLogC2, 2) = 1.0 / p.point.c2;
  T(kColumnLogBeta, 3) = 1.0 / p.point.beta;
  for (int j = 0; j < 4; ++j) T.col(j) *= tableOne()[j].magnitude;
  Eigen::Matrix<double, kBaseColumns, 1> e = Eigen::Matrix<double, kBaseColumns, 1>::Zero();
  e[kColumnTarget] = 1.0;
  e[kColumnDischarge] = -p.theta[0];
  e[kColumnCharge] = -p.theta[1];

  // eq. 4: the mean goes into u_dc, so every column counts with its mean taken off.
  const BaseSums plain = window.unweighted.sums(p.point);
  const Eigen::Matrix<double, kBaseColumns, 1> mean =
      plain.col(kColumnOne) / plain(kColumnOne, kColumnOne);
  const Eigen::Matrix<double, kBaseColumns, 1> ones = sums.col(kColumnOne);
  const BaseSums centred = sums - mean * ones.transpose() - ones * mean.transpose() +
                           sums(kColumnOne, kColumnOne) * mean * mean.transpose();
  p.u_dc = window.weighted.offset() + mean.dot(e);
  p.equations = {std::max(e.dot(centred * e), 0.0), -T.transpose() * (centred * e),
                 T.transpose() * centred * T};
  for (int j = 0; j < 4; ++j) {
    const Penalty penalty = penaltyOf(tableOne()[j], p.theta[j]);
    p.equations.cost += penalty.residual * penalty.residual;
    p.equations.gradient[j] += penalty.slope * penalty.residual;
    p.equations.hessian(j, j) += penalty.slope * penalty.slope;
  }
  return p;
}

BaseFit search(const BaseNormalEquations& equations, const IdentifyOptions& options,
               const BaseFit& start, double trusted_gain) {
  LinearSolution linear;  // of the best point so far
  BaseSums best;
  const auto evaluate = [&](const Eigen::VectorXd& x, NormalEquations& at) {
    const BaseSums sums = equations.sums(pointOf(x));
    if (!sums.allFinite()) return false;
    const LinearSolution solution = solveLinear(sums, options.initial);
    eliminate(sums, solution, at);
    if (solution.cost < linear.cost) {
      linear = solution;
      best = sums;
    }
    return true;
  };
  MinimizeOptions settings;
  settings.max_iterations = options.max_iterations;
  settings.trusted_gain = trusted_gain;
  const std::array<double, 3> from{start.parameters.c2, start.parameters.beta, start.u_c2_first};
  Eigen::VectorXd x0(3);
  for (auto* bound : {&settings.lower, &settings.upper}) bound->resize(3);
  for (std::size_t k = 0; k < 3; ++k) {
    const FitCoordinate& c = searched()[k];
    const auto j = static_cast<Eigen::Index>(k);
    settings.lower[j] = c.of(c.lower);
    settings.upper[j] = c.of(c.upper);
    x0[j] = c.of(from[k]);
  }
  const MinimizeResult found = minimize(evaluate, x0, settings);
  if (!found.last_step.isZero(0.0)) follow(best, found.last_step, linear);

  const OverpotentialSweep::Point point = pointOf(found.x);
  BaseFit fit;
  fit.parameters.r_discharge = linear.value[0];
  fit.parameters.r_charge = linear.value[1];
  fit.parameters.u_dc = linear.value[2] + equations.offset();
  fit.parameters.c2 = point.c2;
  fit.parameters.beta = point.beta;
  fit.u_c2_first = point.u_c2_first;
  fit.cost = found.at.cost;
  fit.status = found.status;
  fit.iterations = found.iterations + (found.last_step.isZero(0.0) ? 0 : 1);
  return fit;
}

BaseFit startOf(const IdentifyOptions& options) {
  BaseFit start;
  start.parameters.r_discharge = options.initial[0];
  start.parameters.r_charge = options.initial[1];
  start.parameters.c2 = options.initial[2];
  start.parameters.beta = options.initial[3];
  return start;
}

}  // namespace

BaseFit searchWindow(const WindowSamples& samples, const BaseNormalEquations& equations,
                     const IdentifyOptions& options) {
  BaseFit start = startOf(options);
  if (samples.size() >= kCoarseFrom) {
    const BaseNormalEquations coarse(coarsened(samples, kCoarseFactor), start.parameters.i0);
    start = search(coarse, options, start, 0.0);
  }
  return search(equations, options, start, kTrustedGain);
}

BaseFit searchAsInPaper(const WindowSamples& samples, const IdentifyOptions& options,
                        const FirstSample& first) {
  auto weighted = samples.copied();
  weighted.front().weight = 0.0;
  auto unweighted = weighted;
  for (auto& sample : unweighted) sample.weight = sample.weight > 0.0 ? 1.0 : 0.0;
  const double i0 = BaseParameters{}.i0;
  const PaperWindow window{BaseNormalEquations(weighted, i0), BaseNormalEquations(unweighted, i0),
                           first};
  Eigen::VectorXd x(4);
  for (int j = 0; j < 4; ++j) x[j] = options.initial[j] / tableOne()[j].magnitude;
  double u_dc = BaseParameters{}.u_dc;  // Table I: 12 V at the first iteration
  MinimizeOptions one_step;
  one_step.max_iterations = 1;
  BaseFit fit;
  fit.status = FitStatus::kIterationLimit;
  for (fit.iterations = 0; fit.iterations < options.max_iterations; ++fit.iterations) {
    const auto evaluate = [&](const Eigen::VectorXd& trial, NormalEquations& at) {
      at = evaluateAsInPaper(window, u_dc, trial).equations;
      return std::isfinite(at.cost) && at.hessian.allFinite();
    };
    const MinimizeResult step = minimize(evaluate, x, one_step);
    const double u_dc_before = u_dc;
    x = step.x;
    u_dc = evaluateAsInPaper(window, u_dc, x).u_dc;
    one_step.initial_damping = step.damping;
    // Converged for this u_dc; done once u_dc itself stands still (1 uV, far below any sensor).
    const bool u_dc_stands = std::abs(u_dc - u_dc_before) < 1e-6;
    if (step.status == FitStatus::kStalled ||
        (step.status == FitStatus::kConverged && u_dc_stands)) {
      fit.status = step.status;
      break;
    }
  }
  const PaperPoint end = evaluateAsInPaper(window, u_dc, x);
  fit.parameters.r_discharge = end.theta[0];
  fit.parameters.r_charge = end.theta[1];
  fit.parameters.c2 = end.point.c2;
  fit.parameters.beta = end.point.beta;
  fit.parameters.u_dc = end.u_dc;
  fit.u_c2_first = end.point.u_c2_first;
  fit.cost = end.equations.cost;
  return fit;
}

}  // namespace battery_sof
