#include "battery_sof/identify/base_normal_equations.hpp"

#include <algorithm>

namespace battery_sof {
namespace {

static_assert(kLinearColumns == kColumnLogC2 && kLinearColumns + kStateColumns == kBaseColumns);

/// The lanes' sums as the symmetric matrix of all columns, without the linear ones among
/// themselves.
Eigen::Matrix<double, kBaseColumns, kBaseColumns> joined(const LaneProducts& products) {
  using Lanes = Eigen::Map<const Eigen::Array<double, kLanes, 1>>;
  Eigen::Matrix<double, kBaseColumns, kBaseColumns> total;
  for (int j = 0; j < kStateColumns; ++j) {
    const int row = kLinearColumns + j;
    for (int k = 0; k < kLinearColumns; ++k)
      total(row, k) = total(k, row) = Lanes(products.with_linear[j][k]).sum();
    for (int k = j; k < kStateColumns; ++k)
      total(row, kLinearColumns + k) = total(kLinearColumns + k, row) =
          Lanes(products.with_states[j][k]).sum();
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

}  // namespace

BaseNormalEquations::BaseNormalEquations(const std::vector<Sample>& samples, double i0)
    : size_(static_cast<Eigen::Index>(samples.size())),
      sweep_(samples.size(), i0, [&](std::size_t n) { return samples[n].held; }),
      measured_(static_cast<std::size_t>(sweep_.blocks())) {
  for (const auto& sample : samples) offset_ += sample.voltage;
  offset_ /= static_cast<double>(size_);
  for (std::size_t first = 0; first < samples.size(); first += kBlockSize) {
    MeasuredBlock& block = measured_[first / kBlockSize];
    const auto count = std::min<std::size_t>(kBlockSize, samples.size() - first);
    for (std::size_t k = 0; k < count; ++k) {
      const Sample& sample = samples[first + k];
      const int place = lanePosition(static_cast<int>(k));
      block.discharge[place] = sample.discharge;
      block.charge[place] = sample.charge;
      block.voltage[place] = sample.voltage - offset_;
      block.weight[place] = sample.weight;
    }
    addLinear(block, linear_);
  }
  linear_.triangularView<Eigen::StrictlyUpper>() = linear_.transpose();
}

BaseSums BaseNormalEquations::sums(const OverpotentialSweep::Point& point,
                                   InstructionSet set) const {
  LaneProducts products = {};
  sweep_.runInLanes(point, set, [&](Eigen::Index block, const OverpotentialStates& states) {
    addProducts(measured_[static_cast<std::size_t>(block)], states, products, set);
  });
  BaseSums total{joined(products)};
  total.weighted.topLeftCorner<kLinearColumns, kLinearColumns>() = linear_;
  return total;
}

Eigen::Matrix<double, kBaseColumns, 1> BaseNormalEquations::means(
    const OverpotentialSweep::Point& point) const {
  const Columns all = columns(point);
  Eigen::VectorXd present(size_);
  for (Eigen::Index n = 0; n < size_; ++n) {
    const auto place = static_cast<std::size_t>(n);
    present[n] =
        measured_[place / kBlockSize].weight[lanePosition(static_cast<int>(place % kBlockSize))] >
                0.0
            ? 1.0
            : 0.0;
  }
  return all.transpose() * present / std::max(present.sum(), 1.0);
}

BaseNormalEquations::Columns BaseNormalEquations::columns(
    const OverpotentialSweep::Point& point) const {
  Columns all(sweep_.blocks() * kBlockSize, kBaseColumns);
  sweep_.run(point, [&](Eigen::Index block, const OverpotentialSweep::States& states) {
    const MeasuredBlock& measured = measured_[static_cast<std::size_t>(block)];
    auto rows = all.middleRows<kBlockSize>(block * kBlockSize);
    for (int k = 0; k < kBlockSize; ++k) {
      const int place = lanePosition(k);
      rows(k, kColumnDischarge) = measured.discharge[place];
      rows(k, kColumnCharge) = measured.charge[place];
      rows(k, kColumnTarget) = measured.voltage[place] - states.u_c2[k];
    }
    rows.col(kColumnOne).setOnes();
    rows.col(kColumnLogC2) = states.d_log_c2;
    rows.col(kColumnLogBeta) = states.d_log_beta;
    rows.col(kColumnInitial) = states.d_initial;
  });
  all.conservativeResize(size_, kBaseColumns);
  return all;
}

std::vector<BaseNormalEquations::Sample> fitSamples(const Series& series, IndexRange range,
                                                    double weight, double weight_current) {
  const auto held = heldCurrents(series, range, gapThreshold(series));
  std::vector<BaseNormalEquations::Sample> samples;
  samples.reserve(range.size());
  for (std::size_t n = range.first; n < range.last; ++n) {
    const double i = series.current[n];
    samples.push_back({held[n - range.first], std::min(i, 0.0), std::max(i, 0.0), series.voltage[n],
                       i < weight_current ? weight * weight : 1.0});
  }
  return samples;
}

std::vector<BaseNormalEquations::Sample> coarsened(
    const std::vector<BaseNormalEquations::Sample>& samples, std::size_t factor) {
  std::vector<BaseNormalEquations::Sample> coarse;
  coarse.reserve(samples.size() / factor + 1);
  std::size_t held_from = 0;
  for (std::size_t first = 0; first < samples.size(); first += factor) {
    const std::size_t last = std::min(first + factor, samples.size());
    BaseNormalEquations::Sample mean{{0.0, 0.0}, 0.0, 0.0, 0.0, 0.0};
    for (std::size_t n = first; n < last; ++n) {
      mean.discharge += samples[n].discharge;
      mean.charge += samples[n].charge;
      mean.voltage += samples[n].voltage;
      mean.weight += samples[n].weight;
    }
    const double count = static_cast<double>(last - first);
    mean.discharge /= count;
    mean.charge /= count;
    mean.voltage /= count;
    // The state in the middle stands for the mean of the state: from middle to middle the current
    // is held.
    const std::size_t held_to = first + (last - first + 1) / 2;
    for (std::size_t n = held_from; n < held_to; ++n) {
      mean.held.duration += samples[n].held.duration;
      mean.held.current += samples[n].held.current * samples[n].held.duration;
    }
    if (mean.held.duration > 0.0) mean.held.current /= mean.held.duration;
    held_from = held_to;
    coarse.push_back(mean);
  }
  return coarse;
}

}  // namespace battery_sof
