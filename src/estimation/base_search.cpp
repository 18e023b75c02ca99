#include "estimation/base_search.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "regression/levenberg_marquardt.hpp"

namespace battery_sof {
namespace {

constexpr double kPenaltySteepness = 10.0;
constexpr int kPaperIterations = 20;  // paper, section V
constexpr int kValleyRounds = 25;     // of as many iterations
// Windows longer than this are first approached on averages of kCoarseFactor samples.
constexpr std::size_t kCoarseFrom = 4000;
constexpr std::size_t kCoarseFactor = 20;
// Share of the cost below which a last step needs no second look, see searchWindow().
constexpr double kTrustedGain = 1e-5;

/// Passes over a window as a problem in (r_discharge, r_charge, ln c2, ln beta, u_dc, first u_c2).
class BaseProblem final : public LeastSquaresProblem {
 public:
  BaseProblem(const BaseNormalEquations& equations, const CompositionPoint& start)
      : LeastSquaresProblem(BatteryModel(), start, 0.0, std::vector<KnownParameter>()),
        equations_(equations) {}

  bool evaluate(const Eigen::VectorXd& x, NormalEquations& at) const override {
    static constexpr std::array<int, kColumnTarget> kColumnOf = {
        kColumnDischarge, kColumnCharge, kColumnLogC2, kColumnLogBeta, kColumnOne, kColumnInitial};
    const CompositionPoint point = pointAt(x);
    const Eigen::VectorXd& p = point.parameters;
    const BaseSums sums = equations_.sums({p[kRowC2], p[kRowBeta], point.state[0]});
    if (!sums.allFinite()) return false;
    Eigen::Matrix<double, kBaseColumns, 1> e = Eigen::Matrix<double, kBaseColumns, 1>::Zero();
    e[kColumnTarget] = 1.0;
    e[kColumnDischarge] = -p[kRowRDischarge];
    e[kColumnCharge] = -p[kRowRCharge];
    e[kColumnOne] = equations_.offset() - p[kRowUDc];
    const Eigen::Matrix<double, kBaseColumns, 1> with_residual = sums * e;
    at.cost = std::max(e.dot(with_residual), 0.0);
    at.gradient.resize(size());
    at.hessian.resize(size(), size());
    for (Eigen::Index k = 0; k < size(); ++k) {
      // The columns of c2 and beta are those of their logarithms already.
      const int column = kColumnOf[k];
      at.gradient[k] = -(*this)[k].unit * with_residual[column];
      for (Eigen::Index l = 0; l < size(); ++l)
        at.hessian(k, l) = (*this)[k].unit * (*this)[l].unit * sums(column, kColumnOf[l]);
    }
    return true;
  }

 private:
  const BaseNormalEquations& equations_;
};

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
  Sample first;
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
  const Sample& first = window.first;
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

}  // namespace

CompositionFit searchWindow(const WindowSamples& samples, const BaseNormalEquations& equations,
                            const IdentifyOptions& options) {
  const auto& [r_discharge, r_charge, c2, beta] = options.initial;
  CompositionPoint point{Eigen::VectorXd(kBaseRows), Eigen::VectorXd::Zero(1)};
  point.parameters << r_discharge, r_charge, c2, beta, equations.offset();
  CompositionSearch search;
  search.max_iterations = options.max_iterations;
  int approached = 0;
  if (samples.size() >= kCoarseFrom) {
    const BaseNormalEquations coarse(coarsened(samples, kCoarseFactor), BaseParameters{}.i0);
    search.trusted_gain = 0.0;
    const CompositionFit approach = fitComposition(BaseProblem(coarse, point), {point}, search);
    point = approach.point;
    approached = approach.iterations;
  }
  search.trusted_gain = kTrustedGain;
  CompositionFit fit = fitComposition(BaseProblem(equations, point), {point}, search);
  fit.iterations += approached;
  // What a short window does not determine leaves a valley, which takes many steps; they cost little.
  const bool is_short = samples.size() < kCoarseFrom && options.max_iterations >= kPaperIterations;
  for (int round = 1; is_short && round < kValleyRounds && fit.status == FitStatus::kIterationLimit;
       ++round) {
    const int before = fit.iterations;
    fit = fitComposition(BaseProblem(equations, fit.point), {fit.point}, search);
    fit.iterations += before;
  }
  return fit;
}

CompositionFit searchAsInPaper(const WindowSamples& samples, const IdentifyOptions& options,
                               const Sample& first) {
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
  CompositionFit fit;
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
  fit.point = {Eigen::VectorXd(kBaseRows), Eigen::VectorXd(1)};
  fit.point.parameters << end.theta[0], end.theta[1], end.point.c2, end.point.beta, end.u_dc;
  fit.point.state << end.point.u_c2_first;
  fit.at.cost = end.equations.cost;
  return fit;
}

}  // namespace battery_sof
