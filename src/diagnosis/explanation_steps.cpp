#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "explanation_fits.hpp"

namespace battery_sof {
namespace {

// of a step, tried one after the other
constexpr std::array<double, 4> kShares = {1.0, 0.35, 0.1, 0.01};
constexpr double kAtBound = 1e-9;  // of a coordinate

}  // namespace

/// The cost of a step y of a state's coordinates, at one noise s and one strength a group:
///
///     q(y) = |e(y)|^2 + s^2 / f sum ((y - y_0) / std)^2 - h' F^-1 h,   h = A' e(y)  [V^2]
///
/// e: innovations of the rows, A: columns, fitted along, F: A'A and their priors, f: effective
/// sample fraction.
class ExplanationFits::StepCost {
 public:
  /// @param sums of the state.
  StepCost(const ExplanationFits& fits, const ExplanationState& state, const ExplanationSums& sums)
      : state_(state) {
    Eigen::VectorXd std;
    const Eigen::VectorXd expected = expectedFrom(state, std);
    const LinearProblem& rows = sums.problem;
    const Eigen::Index known = rows.known(), free = rows.products.rows() - known;
    const Eigen::MatrixXd H = fits.penalised(sums, state);
    const Eigen::MatrixXd across = H.topRightCorner(known, free);
    columns_.compute(H.bottomRightCorner(free, free));
    H_ = H.topLeftCorner(known, known) - across * columns_.solve(across.transpose());
    target_ =
        rows.targets.head(known) - across * columns_.solve(rows.targets.tail(free)) + H_ * expected;
    in_evidence_ = 0.5 * fits.effectiveSampleFraction() / (state.fit.noise * state.fit.noise);
  }

  /// ln evidence that a step gains as far as the rows are linear in it.
  double gainOf(const Eigen::VectorXd& step) const {
    return in_evidence_ * (2.0 * target_.dot(step) - step.dot(H_ * step));
  }

  /// The step of greatest gain within the coordinates' bounds.
  Eigen::VectorXd step() const {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(H_.rows());
    std::vector<Eigen::Index> loose(H_.rows());
    std::iota(loose.begin(), loose.end(), 0);
    const auto staysOutside = [&](Eigen::Index j) {
      const FitCoordinate& c = state_.coordinates[j];
      const double x = c.of(state_.point[c.row]);
      const double held = c.of(c.value(x + step[j])) - x;
      const bool crosses = std::abs(held - step[j]) > kAtBound;
      if (crosses) step[j] = held;
      return crosses;
    };
    while (!loose.empty()) {
      Eigen::VectorXd held = step;
      held(loose).setZero();
      const Eigen::VectorXd target = (target_ - H_ * held)(loose);
      const Eigen::VectorXd solved = Eigen::MatrixXd(H_(loose, loose)).ldlt().solve(target);
      step(loose) = solved;
      const auto end = std::remove_if(loose.begin(), loose.end(), staysOutside);
      if (end == loose.end()) break;
      loose.erase(end, loose.end());
    }
    return step;
  }

 private:
  const ExplanationState& state_;
  Eigen::VectorXd target_;
  Eigen::MatrixXd H_;  // of the coordinates, the columns eliminated
  Eigen::LDLT<Eigen::MatrixXd> columns_;
  double in_evidence_ = 0.0;  // [1/V^2]
};

void ExplanationFits::improve(ExplanationState& state, int iterations, double settled) const {
  if (!std::isfinite(state.evidence)) return;
  ExplanationSums sums = sumsOf(state, false);
  for (int round = 0; round < iterations; ++round) {
    const StepCost cost(*this, state, sums);
    ExplanationState next = state;
    ExplanationSums there;
    const Eigen::VectorXd step = cost.step();
    if (cost.gainOf(step) < settled) return;
    double gained = 0.0;  // ln evidence
    for (const double share : kShares) {
      for (std::size_t j = 0; j < next.coordinates.size(); ++j) {
        const FitCoordinate& c = next.coordinates[j];
        next.point[c.row] = c.value(c.of(state.point[c.row]) + share * step[j]);
      }
      if (!linearize(next)) continue;
      there = evaluateEvidence(next);
      gained = next.evidence - state.evidence;
      if (gained > 0.0) break;
    }
    if (!(gained > 0.0)) return;
    state = std::move(next);
    sums = std::move(there);
    if (gained < settled) return;
  }
}

}  // namespace battery_sof
