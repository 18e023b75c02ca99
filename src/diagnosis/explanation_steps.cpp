#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "explanation_fits.hpp"

namespace battery_sof {
namespace {

// of a step that the rows do not follow, one after the other
constexpr std::array<double, 4> kDampings = {0.1, 1.0, 10.0, 100.0};
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
  StepCost(const ExplanationFits& fits, const ExplanationState& state)
      : fits_(fits), state_(state), sums_(fits.sumsOf(state, false)) {
    expected_ = expectedFrom(state, std_);
    const Eigen::Index known = expected_.size(), free = sums_.problem.products.rows() - known;
    const Eigen::MatrixXd H = fits.penalised(sums_, state);
    const Eigen::MatrixXd across = H.topRightCorner(known, free);
    columns_.compute(H.bottomRightCorner(free, free));
    H_ = H.topLeftCorner(known, known) - across * columns_.solve(across.transpose());
    target_ = sums_.problem.targets.head(known) -
              across * columns_.solve(sums_.problem.targets.tail(free)) + H_ * expected_;
    in_evidence_ = 0.5 * fits.effectiveSampleFraction() / (state.fit.noise * state.fit.noise);
    here_ = at(state, state.error);
  }

  /// ln evidence that a state elsewhere gains; minus infinity without a finite voltage.
  double gainFrom(const ExplanationState& next, const Eigen::VectorXd& error) const {
    return in_evidence_ * (here_ - at(next, error));
  }

  /// [V^2]; infinite without a finite voltage.
  double at(const ExplanationState& state, const Eigen::VectorXd& error) const {
    if (error.size() == 0) return std::numeric_limits<double>::infinity();
    Eigen::VectorXd std;
    const Eigen::VectorXd from_prior = expectedFrom(state, std).cwiseQuotient(std);
    const Eigen::VectorXd rows = fits_.whitened(error);
    const Eigen::VectorXd h = sums_.columns.along(rows).tail(columns_.rows());
    return rows.squaredNorm() + 0.5 * from_prior.squaredNorm() / in_evidence_ -
           h.dot(columns_.solve(h));
  }

  /// ln evidence that a step gains as far as the rows are linear in it.
  double gainOf(const Eigen::VectorXd& step) const {
    return in_evidence_ * (2.0 * target_.dot(step) - step.dot(H_ * step));
  }

  /// The step of greatest gain within the coordinates' bounds.
  /// @param damping a share of what the rows say of each coordinate [1].
  Eigen::VectorXd step(double damping) const {
    Eigen::MatrixXd H = H_;
    H.diagonal() *= 1.0 + damping;
    Eigen::VectorXd step = Eigen::VectorXd::Zero(H.rows());
    std::vector<Eigen::Index> loose(static_cast<std::size_t>(H.rows()));
    std::iota(loose.begin(), loose.end(), 0);
    const auto staysOutside = [&](Eigen::Index j) {
      const FitCoordinate& c = state_.coordinates[static_cast<std::size_t>(j)];
      const double x = c.of(ExplanationFits::at(state_.point, c.row));
      const double held = c.of(c.value(x + step[j])) - x;
      const bool crosses = std::abs(held - step[j]) > kAtBound;
      if (crosses) step[j] = held;
      return crosses;
    };
    while (!loose.empty()) {
      Eigen::VectorXd held = step;
      held(loose).setZero();
      const Eigen::VectorXd target = (target_ - H * held)(loose);
      const Eigen::VectorXd solved = Eigen::MatrixXd(H(loose, loose)).ldlt().solve(target);
      step(loose) = solved;
      const auto end = std::remove_if(loose.begin(), loose.end(), staysOutside);
      if (end == loose.end()) break;
      loose.erase(end, loose.end());
    }
    return step;
  }

 private:
  const ExplanationFits& fits_;
  const ExplanationState& state_;
  ExplanationSums sums_;
  Eigen::VectorXd expected_, std_, target_;
  Eigen::MatrixXd H_;  // of the coordinates, the columns eliminated
  Eigen::LDLT<Eigen::MatrixXd> columns_;
  double in_evidence_ = 0.0;  // [1/V^2]
  double here_ = 0.0;         // [V^2]
};

void ExplanationFits::improve(ExplanationState& state, int iterations, double settled) const {
  for (int round = 0; round < iterations && std::isfinite(state.evidence); ++round) {
    const StepCost cost(*this, state);
    ExplanationState next = state;
    const auto step = [&](double damping) {
      const Eigen::VectorXd by = cost.step(damping);
      if (cost.gainOf(by) < settled) return false;
      for (std::size_t j = 0; j < next.coordinates.size(); ++j) {
        const FitCoordinate& c = next.coordinates[j];
        at(next.point, c.row) =
            c.value(c.of(at(state.point, c.row)) + by[static_cast<Eigen::Index>(j)]);
      }
      return true;
    };
    if (!step(0.0)) return;
    double gained = 0.0;  // ln evidence
    if (linearize(next)) {
      evaluateEvidence(next);
      gained = std::max(next.evidence - state.evidence, cost.gainFrom(next, next.error));
    }
    for (std::size_t k = 0; k < kDampings.size() && !(gained > 0.0); ++k) {
      if (!step(kDampings[k])) return;
      gained = cost.gainFrom(next, errorsOf(next.model, next.point));
      if (!(gained > 0.0)) continue;
      if (!linearize(next)) return;
      evaluateEvidence(next);
    }
    if (!(gained > 0.0)) return;
    state = std::move(next);
    if (gained < settled) return;
  }
}

}  // namespace battery_sof
