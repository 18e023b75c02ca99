#include "estimation/base_residual.hpp"

#include <utility>

namespace battery_sof {
namespace {

using LaneArray = Eigen::Map<const Eigen::Array<double, kLanes, 1>>;

BaseMatrix joined(const ScoreProducts& products) {
  BaseMatrix total;
  for (int j = 0; j < kScoreColumns; ++j)
    for (int k = 0; k <= j; ++k) total(j, k) = total(k, j) = LaneArray(products.sums[j][k]).sum();
  return total;
}

}  // namespace

BaseResidual::BaseResidual(std::vector<MeasuredBlock> blocks, std::vector<SweptBlock> derivatives,
                           std::size_t size, const ResidualSums& full_blocks)
    : blocks_(std::move(blocks)),
      derivatives_(std::move(derivatives)),
      size_(size),
      squares_(LaneArray(full_blocks.squares).sum()) {
  const std::size_t full = size_ / kBlockSize * kBlockSize;
  double sum = LaneArray(full_blocks.residual).sum(), lagged = LaneArray(full_blocks.lagged).sum();
  for (std::size_t n = kLaneSteps; n < full; n += kLaneSteps) lagged += at(n) * at(n - 1);
  for (std::size_t n = full; n < size_; ++n) {
    sum += at(n);
    squares_ += at(n) * at(n);
    if (n > 0) lagged += at(n) * at(n - 1);
  }
  lag_one_ = lagOneOf(sum, lagged);
}

/// @param sum of e(n).  @param lagged of e(n) e(n - 1).
double BaseResidual::lagOneOf(double sum, double lagged) const {
  const double count = static_cast<double>(size_), mean = sum / count;
  const double power = squares_ - count * mean * mean;
  if (size_ < 3 || !(power > 0.0)) return 0.0;
  const double ends = at(0) + at(size_ - 1);
  return (lagged - mean * (2.0 * sum - ends) + (count - 1.0) * mean * mean) / power;
}

BaseMatrix BaseResidual::bartlettProducts(Eigen::Index width) const {
  if (width <= kLaneSteps)
    return movingProducts(static_cast<int>(width)) / static_cast<double>(width);
  return bartlettSum(scoreSums(), (width + kScoreSteps / 2) / kScoreSteps);
}

BaseMatrix BaseResidual::movingProducts(int width) const {
  static const MeasuredBlock kNothing = {};  // what comes after the last sample
  const InstructionSet set = widestInstructionSet();
  MovingScores moving = {};
  ScoreProducts products = {};
  for (std::size_t block = 0; block < blocks_.size(); ++block)
    addMovingProducts(blocks_[block], derivatives_[block].derivatives, width, moving, products,
                      set);
  addMovingProducts(kNothing, derivatives_.back().derivatives, width, moving, products, set);
  return joined(products);
}

BartlettSums BaseResidual::scoreSums() const {
  BartlettSums rows(static_cast<Eigen::Index>(blocks_.size()) * kLanes * kScoreSums, kScoreColumns);
  ScoreSums sums;
  for (std::size_t block = 0; block < blocks_.size(); ++block) {
    addUpScores(blocks_[block], derivatives_[block].derivatives, sums, widestInstructionSet());
    const auto first = static_cast<Eigen::Index>(block) * kLanes * kScoreSums;
    for (int lane = 0; lane < kLanes; ++lane)
      for (int k = 0; k < kScoreSums; ++k)
        for (int j = 0; j < kScoreColumns; ++j)
          rows(first + Eigen::Index{lane} * kScoreSums + k, j) = sums.scores[k][j][lane];
  }
  return rows;
}

}  // namespace battery_sof
