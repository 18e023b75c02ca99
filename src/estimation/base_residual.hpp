#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimation/covariance.hpp"
#include "estimation/scores_kernel.hpp"
#include "model/base_model.hpp"

namespace battery_sof {

/// A matrix over the six unknowns of the base model, in the order of BaseColumn.
using BaseMatrix = Eigen::Matrix<double, kScoreColumns, kScoreColumns>;

/**
 * @brief What a fit of the base model leaves over its window, and what its covariance is made of.
 *
 * BaseNormalEquations::residual() makes it and hands its memory over: a window takes no more of it
 * than its search did.
 */
class BaseResidual {
 public:
  /// @param blocks leaveResidual()'s.  @param derivatives of the same blocks.  @param size samples,
  /// the last block's rest without weight.
  /// @param full_blocks sums over the blocks without such a rest.
  BaseResidual(std::vector<MeasuredBlock> blocks, std::vector<SweptBlock> derivatives,
               std::size_t size, const ResidualSums& full_blocks);

  BaseMatrix information = BaseMatrix::Zero();  ///< A = sum_n W(n)^2 column_j column_k
  Overpotential last;                           ///< at the window's last sample

  /// @return e of the window's n-th sample, u_b - u_m [V].
  double at(std::size_t n) const {
    return blocks_[n / kBlockSize].voltage[lanePosition(static_cast<int>(n % kBlockSize))];
  }
  /// sum of e(n)^2 over all samples, those without weight too [V^2]
  double squares() const { return squares_; }
  double lagOne() const { return lag_one_; }  ///< lagOneCorrelation() of e

  /**
   * @brief B of the sandwich (sandwichCovariance()).
   *
   * Up to kLaneSteps samples of width exactly; from there on over sums of kScoreSteps samples, the
   * width rounded to a multiple of them (bartlettSum()): standard errors are those of
   * sandwichCovariance() to 3 %.
   * @param width L [samples], at least 1.
   */
  BaseMatrix bartlettProducts(Eigen::Index width) const;

 private:
  BaseMatrix movingProducts(int width) const;
  BartlettSums scoreSums() const;
  double lagOneOf(double sum, double lagged) const;

  std::vector<MeasuredBlock> blocks_;
  std::vector<SweptBlock> derivatives_;
  std::size_t size_;
  double squares_ = 0.0, lag_one_ = 0.0;
};

}  // namespace battery_sof
