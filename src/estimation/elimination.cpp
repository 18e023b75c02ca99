#include "elimination.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace battery_sof {
namespace {

NormalEquations shifted(NormalEquations at, const Eigen::VectorXd& step) {
  const Eigen::VectorXd curved = at.hessian * step;
  at.cost += (2.0 * at.gradient + curved).dot(step);
  at.gradient += curved;
  return at;
}

}  // namespace

Elimination::Elimination(const CompositionProblem& problem, bool eliminate,
                         const Eigen::VectorXd& start)
    : problem_(problem), full_(start) {
  for (Eigen::Index k = 0; k < problem.size(); ++k)
    (eliminate && problem[k].linear ? linear_ : others_).push_back(k);
}

bool Elimination::evaluate(const Eigen::VectorXd& y, NormalEquations& equations) {
  ++passes_;
  // The linear coordinates go along as the last pass sees them: the others' columns depend on them.
  Eigen::VectorXd x = last_.size() > 0 ? predicted(y - last_).x : full_;
  x(others_) = y;
  last_.resize(0);
  NormalEquations& all = all_;
  if (!problem_.evaluate(x, all)) return false;
  last_ = y;
  passed_ = x;
  const Eigen::VectorXd step = solveLinear(x, all);
  const Eigen::VectorXd gradient = all.gradient + all.hessian * step;
  equations.cost = all.cost + (2.0 * all.gradient + all.hessian * step).dot(step);
  equations.gradient = gradient(others_);
  equations.hessian = all.hessian(others_, others_);
  if (!moved_.empty()) {
    const Eigen::MatrixXd across = all.hessian(moved_, others_);
    const Eigen::MatrixXd own = all.hessian(moved_, moved_);
    equations.hessian -= across.transpose() * own.ldlt().solve(across);
  }
  full_ = inside(x + step);
  return std::isfinite(equations.cost);
}

bool Elimination::wasAt(const Eigen::VectorXd& y) const {
  return last_.size() == y.size() &&
         (last_ - y).cwiseAbs().maxCoeff() <= 1e-13 * (1.0 + y.cwiseAbs().maxCoeff());
}

std::optional<NormalEquations> Elimination::movedOn(const Eigen::VectorXd& step, double most) {
  const Predicted there = predicted(step);
  if (!(all_.cost - there.at.cost <= most * all_.cost)) return std::nullopt;
  full_ = there.x;
  return there.at;
}

Elimination::Predicted Elimination::predicted(const Eigen::VectorXd& step) {
  Eigen::VectorXd whole = Eigen::VectorXd::Zero(full_.size());
  whole(others_) = step;
  const NormalEquations moved = shifted(all_, whole);
  const Eigen::VectorXd linear = solveLinear(passed_ + whole, moved);
  return {inside(passed_ + whole + linear), shifted(moved, linear)};
}

Eigen::VectorXd Elimination::solveLinear(const Eigen::VectorXd& x, const NormalEquations& all) {
  Eigen::VectorXd step = Eigen::VectorXd::Zero(x.size());
  moved_ = linear_;
  std::vector<Eigen::Index> held;
  for (std::size_t k = 0; k < 4 * linear_.size() + 4; ++k) {
    const Eigen::Index stopped = moveFree(x, all, step);
    if (stopped >= 0) {
      moved_.erase(std::find(moved_.begin(), moved_.end(), stopped));
      held.push_back(stopped);
      continue;
    }
    const auto released = mostInward(x, all, step, held);
    if (released == held.end()) break;
    moved_.push_back(*released);
    held.erase(released);
  }
  return step;
}

Eigen::Index Elimination::moveFree(const Eigen::VectorXd& x, const NormalEquations& all,
                                   Eigen::VectorXd& step) const {
  if (moved_.empty()) return -1;
  Eigen::MatrixXd own = all.hessian(moved_, moved_);
  own.diagonal() *= 1.0 + 1e-12;
  own.diagonal().array() += 1e-30;
  const Eigen::VectorXd slope = all.gradient + all.hessian * step;
  const Eigen::VectorXd wanted = -own.ldlt().solve(slope(moved_));
  Eigen::Index stopped = -1;
  double share = 1.0, bound = 0.0;
  for (std::size_t k = 0; k < moved_.size(); ++k) {
    const Eigen::Index j = moved_[k];
    const double by = wanted[static_cast<Eigen::Index>(k)];
    if (!std::isfinite(by)) return j;
    const double edge = (by < 0.0 ? problem_.lower()[j] : problem_.upper()[j]) - x[j];
    if (std::abs(by) <= std::abs(edge - step[j])) continue;
    const double reach = std::max(0.0, (edge - step[j]) / by);
    if (reach >= share) continue;
    share = reach;
    stopped = j;
    bound = edge;
  }
  step(moved_) += share * wanted;
  if (stopped >= 0) step[stopped] = bound;
  return stopped;
}

std::vector<Eigen::Index>::iterator Elimination::mostInward(const Eigen::VectorXd& x,
                                                            const NormalEquations& all,
                                                            const Eigen::VectorXd& step,
                                                            std::vector<Eigen::Index>& held) const {
  const Eigen::VectorXd slope = all.gradient + all.hessian * step;
  auto steepest = held.end();
  double most = 1e-9 * std::sqrt(std::max(all.cost, 0.0));
  for (auto at = held.begin(); at != held.end(); ++at) {
    const double here = x[*at] + step[*at];
    const bool at_lower = here - problem_.lower()[*at] < problem_.upper()[*at] - here;
    const double norm = std::sqrt(all.hessian(*at, *at));
    const double inward = (at_lower ? -slope[*at] : slope[*at]) / norm;
    if (!(norm > 0.0) || !(inward > most)) continue;
    most = inward;
    steepest = at;
  }
  return steepest;
}

}  // namespace battery_sof
