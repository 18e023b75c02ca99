#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimation/composition_fit.hpp"

namespace battery_sof {

/// A problem with its linear coordinates solved for the others in every pass (Golub and Pereyra
/// 1973; Kaufman 1975).
class Elimination {
 public:
  /// @param eliminate false: no coordinate counts as linear.  @param start all coordinates.
  Elimination(const CompositionProblem& problem, bool eliminate, const Eigen::VectorXd& start);

  /// @return the coordinates that are searched for.
  Eigen::VectorXd reduced(const Eigen::VectorXd& x) const { return x(others_); }

  /// As CompositionProblem::evaluate(), over the coordinates that are searched for.
  bool evaluate(const Eigen::VectorXd& y, NormalEquations& equations);

  /// Whether the last pass succeeded and was at y, but for rounding.
  bool wasAt(const Eigen::VectorXd& y) const;

  /// Moves on from the last pass by `step` and on to the linear coordinates' optimum, without
  /// another pass: exact but for the curvature of the others. @return nothing when that promises
  /// more than a share `most` of the cost.
  std::optional<NormalEquations> movedOn(const Eigen::VectorXd& step, double most);

  /// All coordinates at the last pass' y.
  const Eigen::VectorXd& full() const { return full_; }
  int passes() const { return passes_; }

 private:
  struct Predicted {
    Eigen::VectorXd x;
    NormalEquations at;
  };
  /// What the last pass promises `step` away, the linear coordinates at their optimum.
  Predicted predicted(const Eigen::VectorXd& step);

  /// Against rounding: steps end on bounds.
  Eigen::VectorXd inside(const Eigen::VectorXd& x) const {
    return x.cwiseMax(problem_.lower()).cwiseMin(problem_.upper());
  }

  /// Step to the optimum over the linear coordinates inside their bounds, by the primal active-set
  /// method: along the unbounded solution to the first bound in the way, which then holds; a bound
  /// is left when the cost falls inwards. The cost never rises on the way. moved_ are then the
  /// coordinates that no bound holds.
  Eigen::VectorXd solveLinear(const Eigen::VectorXd& x, const NormalEquations& all);

  /// Moves the free coordinates towards their optimum. @return the one that a bound stopped; -1
  /// when none did.
  Eigen::Index moveFree(const Eigen::VectorXd& x, const NormalEquations& all,
                        Eigen::VectorXd& step) const;

  /// @return the held coordinate from whose bound the cost falls most steeply; end when there is
  /// none.
  std::vector<Eigen::Index>::iterator mostInward(const Eigen::VectorXd& x,
                                                 const NormalEquations& all,
                                                 const Eigen::VectorXd& step,
                                                 std::vector<Eigen::Index>& held) const;

  const CompositionProblem& problem_;
  Eigen::VectorXd full_;
  NormalEquations all_;            // of the last pass
  Eigen::VectorXd last_, passed_;  // its y, and all coordinates
  std::vector<Eigen::Index> linear_, others_, moved_;
  int passes_ = 0;
};

}  // namespace battery_sof
