#include "estimation/base_normal_equations.hpp"

#include <algorithm>
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

namespace {

static_assert(kLinearColumns == kColumnLogC2 && kLinearColumns + kStateColumns == kBaseColumns);

/// The SIMD lanes' sums as the symmetric matrix of all columns, without the linear ones
/// among themselves.
BaseSums joined(const LaneProducts& products) {
  BaseSums total;
  for (int j = 0; j < kStateColumns; ++j) {
    const int row = kLinearColumns + j;
    for (int k = 0; k < kLinearColumns; ++k)
      total(row, k) = total(k, row) = LaneArray(products.with_linear[j][k]).sum();
    for (int k = j; k < kStateColumns; ++k)
      total(row, kLinearColumns + k) = total(kLinearColumns + k, row) =
          LaneArray(products.with_states[j][k]).sum();
  }
  return total;
}

/// The state at a place of a block, with its derivatives to C_2 and beta themselves.
Overpotential stateAt(const OverpotentialStates& states, int place,
                      const OverpotentialSweep::Point& point) {
  return {states.u_c2[place], states.d_initial[place], states.d_log_c2[place] / point.c2,
          states.d_log_beta[place] / point.beta};
}

/// Adds a block's products of the linear columns to the lower triangle.
void addLinear(const MeasuredBlock& block, Eigen::Matrix3d& sums) {
  using Values = Eigen::Map<const Eigen::Array<double, kBlockSize, 1>>;
  const Values discharge(block.discharge), charge(block.charge), weight(block.weight);
  sums(0, 0) += (discharge.square() * weight).sum();
  sums(1, 0) += (discharge * charge * weight).sum();
  sums(1, 1) += (charge.square() * weight).sum();
  sums(2, 0) += (discharge * weight).sum();
  sums(2, 1) += (charge * weight).sum();
  sums(2, 2) += weight.sum();
}

}  // namespace

BaseSums BaseNormalEquations::sums(const OverpotentialSweep::Point& point,
                                   InstructionSet set) const {
  LaneProducts products = {};
  sweep_.run(point, set, [&](Eigen::Index block, const OverpotentialStates& states) {
    addProducts(measured_[static_cast<std::size_t>(block)], states, products, set);
  });
  BaseSums total = joined(products);
  total.topLeftCorner<kLinearColumns, kLinearColumns>() = linear_;
  return total;
}

BaseResidual BaseNormalEquations::residual(const OverpotentialSweep::Point& point,
                                           const Eigen::Vector3d& linear) && {
  const InstructionSet set = widestInstructionSet();
  const double values[kLinearColumns] = {linear[0], linear[1], linear[2] - offset_};
  const auto end = static_cast<int>((size_ - 1) % kBlockSize);
  LaneProducts products = {};
  ResidualSums full = {}, partial = {};
  Overpotential last;
  auto derivatives = std::move(sweep_).runOut(
      point, set, [&](Eigen::Index block, const OverpotentialStates& states) {
        MeasuredBlock& measured = measured_[static_cast<std::size_t>(block)];
        const bool is_full = (block + 1) * kBlockSize <= size_;
        addProducts(measured, states, products, set);
        leaveResidual(states, values, measured, is_full ? full : partial, set);
        last = stateAt(states, lanePosition(end), point);  // the last block's stays
      });
  BaseResidual left(std::move(measured_), std::move(derivatives), static_cast<std::size_t>(size_),
                    full);
  left.information = joined(products).topLeftCorner<kScoreColumns, kScoreColumns>();
  left.information.topLeftCorner<kLinearColumns, kLinearColumns>() = linear_;
  left.last = last;
  return left;
}

std::vector<BaseNormalEquations::Sample> WindowSamples::copied() const {
  std::vector<BaseNormalEquations::Sample> samples(size());
  for (std::size_t n = 0; n < samples.size(); ++n) samples[n] = (*this)[n];
  return samples;
}

inline void SampleSums::add(const BaseNormalEquations::Sample& sample) {
  discharge += sample.discharge;
  charge += sample.charge;
  voltage += sample.voltage;
  weight += sample.weight;
  duration += sample.held.duration;
  carried += sample.held.current * sample.held.duration;
}

inline void SampleSums::add(const SampleSums& others) {
  discharge += others.discharge;
  charge += others.charge;
  voltage += others.voltage;
  weight += others.weight;
  duration += others.duration;
  carried += others.carried;
}

namespace {

constexpr std::size_t kFive = 5;

template <typename Samples>
SampleSums oneByOne(const Samples& samples, std::size_t first, std::size_t last) {
  SampleSums sums;
  for (std::size_t n = first; n < last; ++n) sums.add(samples[n]);
  return sums;
}

/// Five by five from a multiple of five on. @param fiveAt the sum of the k-th five.
template <typename Samples, typename FiveAt>
inline SampleSums fiveByFive(const Samples& samples, std::size_t first, std::size_t last,
                             FiveAt&& fiveAt) {
  if (first % kFive != 0 || last - first < kFive) return oneByOne(samples, first, last);
  std::size_t k = first / kFive;
  const std::size_t end = last / kFive;
  SampleSums sums = fiveAt(k);
  while (++k < end) sums.add(fiveAt(k));
  for (std::size_t n = end * kFive; n < last; ++n) sums.add(samples[n]);
  return sums;
}

/// As of WindowSamples, to the last digit.
SampleSums sumOf(const std::vector<BaseNormalEquations::Sample>& samples, std::size_t first,
                 std::size_t last) {
  return fiveByFive(samples, first, last,
                    [&](std::size_t k) { return oneByOne(samples, k * kFive, (k + 1) * kFive); });
}

SampleSums sumOf(const WindowSamples& samples, std::size_t first, std::size_t last) {
  return fiveByFive(samples, first, last,
                    [&](std::size_t k) -> const SampleSums& { return samples.fives()[k]; });
}

}  // namespace

WindowSamples::WindowSamples(const Series& series, IndexRange range, CrankWeight weight,
                             double max_gap, const std::vector<char>& masked)
    : time_(series.time.data() + range.first),
      current_(series.current.data() + range.first),
      voltage_(series.voltage.data() + range.first),
      masked_(masked.empty() ? nullptr : masked.data() + range.first),
      size_(range.size()),
      weight_(weight),
      max_gap_(max_gap) {
  fives_.reserve(size() / kFive);
  for (std::size_t last = kFive; last <= size(); last += kFive)
    fives_.push_back(oneByOne(*this, last - kFive, last));
}

template <typename Samples>
std::vector<BaseNormalEquations::Sample> coarsened(const Samples& samples, std::size_t factor) {
  std::vector<BaseNormalEquations::Sample> coarse;
  coarse.reserve(samples.size() / factor + 1);
  SampleSums before;
  for (std::size_t first = 0; first < samples.size(); first += factor) {
    const std::size_t last = std::min(first + factor, samples.size());
    // The state in the middle represents the mean of the state: from middle to middle the current
    // is held.
    const std::size_t middle = first + (last - first + 1) / 2;
    const SampleSums one = sumOf(samples, first, middle), other = sumOf(samples, middle, last);
    const double share = 1.0 / static_cast<double>(last - first);
    const double duration = before.duration + one.duration, carried = before.carried + one.carried;
    coarse.push_back({{duration > 0.0 ? carried / duration : 0.0, duration},
                      (one.discharge + other.discharge) * share,
                      (one.charge + other.charge) * share,
                      (one.voltage + other.voltage) * share,
                      one.weight + other.weight});
    before = other;
  }
  return coarse;
}

template <typename Samples>
BaseNormalEquations::BaseNormalEquations(const Samples& samples, double i0)
    : size_(static_cast<Eigen::Index>(samples.size())),
      offset_(sumOf(samples, 0, samples.size()).voltage / static_cast<double>(size_)),
      sweep_(samples.size()),
      measured_(static_cast<std::size_t>(sweep_.blocks())) {
  HeldBlock held;
  for (std::size_t block = 0; block < measured_.size(); ++block) {
    const std::size_t first = block * kBlockSize;
    const auto count = std::min<std::size_t>(kBlockSize, samples.size() - first);
    if (count < kBlockSize) held = {};
    for (std::size_t k = 0; k < count; ++k) {
      const Sample sample = samples[first + k];
      const int place = lanePosition(static_cast<int>(k));
      held.current[place] = sample.held.current;
      held.duration[place] = sample.held.duration;
      measured_[block].discharge[place] = sample.discharge;
      measured_[block].charge[place] = sample.charge;
      measured_[block].voltage[place] = sample.voltage - offset_;
      measured_[block].weight[place] = sample.weight;
    }
    sweep_.drive(static_cast<Eigen::Index>(block), held, i0);
    addLinear(measured_[block], linear_);
  }
  linear_.triangularView<Eigen::StrictlyUpper>() = linear_.transpose();
}

template BaseNormalEquations::BaseNormalEquations(const std::vector<Sample>&, double);
template BaseNormalEquations::BaseNormalEquations(const WindowSamples&, double);
template std::vector<BaseNormalEquations::Sample> coarsened(
    const std::vector<BaseNormalEquations::Sample>&, std::size_t);
template std::vector<BaseNormalEquations::Sample> coarsened(const WindowSamples&, std::size_t);

}  // namespace battery_sof
