#include "estimation/base_normal_equations.hpp"

#include <algorithm>

namespace battery_sof {
namespace {

using LaneArray = Eigen::Map<const Eigen::Array<double, kLanes, 1>>;

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

/// What neighbouring samples add up to.
struct SampleSums {
  double discharge = 0.0, charge = 0.0, voltage = 0.0, weight = 0.0;
  double duration = 0.0, carried = 0.0;  // [s], [As]
};

template <typename Samples>
SampleSums sumOf(const Samples& samples, std::size_t first, std::size_t last) {
  SampleSums sums;
  for (std::size_t n = first; n < last; ++n) {
    const BaseNormalEquations::Sample sample = samples[n];
    sums.discharge += sample.discharge;
    sums.charge += sample.charge;
    sums.voltage += sample.voltage;
    sums.weight += sample.weight;
    sums.duration += sample.held.duration;
    sums.carried += sample.held.current * sample.held.duration;
  }
  return sums;
}

}  // namespace

BaseSums BaseNormalEquations::sums(const OverpotentialSweep::Point& point,
                                   InstructionSet set) const {
  LaneProducts products = {};
  sweep_.run(point, set, [&](Eigen::Index block, const OverpotentialStates& states) {
    addProducts(measured_[block], states, products, set);
  });
  BaseSums total = joined(products);
  total.topLeftCorner<kLinearColumns, kLinearColumns>() = linear_;
  return total;
}

BaseJacobian BaseNormalEquations::jacobian(const OverpotentialSweep::Point& point,
                                           const Eigen::Vector3d& linear) const {
  BaseJacobian whole{
      Eigen::MatrixXd(size_, kColumnTarget), Eigen::VectorXd(size_), Eigen::VectorXd(size_), {}};
  const Eigen::Vector3d of_offset(0.0, 0.0, offset_);
  sweep_.run(
      point, widestInstructionSet(), [&](Eigen::Index block, const OverpotentialStates& states) {
        const MeasuredBlock& measured = measured_[block];
        const Eigen::Index first = block * kBlockSize;
        for (Eigen::Index n = first; n < std::min(first + kBlockSize, size_); ++n) {
          const int place = lanePosition(static_cast<int>(n - first));
          whole.columns.row(n) << measured.discharge[place], measured.charge[place], 1.0,
              states.d_log_c2[place], states.d_log_beta[place], states.d_initial[place];
          whole.residual[n] = measured.voltage[place] - states.u_c2[place] -
                              whole.columns.row(n).head<3>().dot(linear - of_offset);
          whole.weight[n] = measured.weight[place];
          whole.last = {states.u_c2[place], states.d_initial[place],
                        states.d_log_c2[place] / point.c2, states.d_log_beta[place] / point.beta};
        }
      });
  return whole;
}

std::vector<BaseNormalEquations::Sample> WindowSamples::copied() const {
  std::vector<BaseNormalEquations::Sample> samples(size());
  for (std::size_t n = 0; n < samples.size(); ++n) samples[n] = (*this)[n];
  return samples;
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
    : size_(samples.size()),
      offset_(samples[samples.size() / 2].voltage),
      sweep_(samples.size()),
      measured_(sweep_.blocks()) {
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
    sweep_.drive(block, held, i0);
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
