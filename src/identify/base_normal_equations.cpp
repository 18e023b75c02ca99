#include "battery_sof/identify/base_normal_equations.hpp"

#include <algorithm>
#include <array>

namespace battery_sof {
namespace {

using BlockColumns = Eigen::Matrix<double, OverpotentialSweep::kBlock, kBaseColumns>;

/// sum_k factor_k column_j,k for the linear columns and those from kFirst on; four samples at a
/// time keep the sums in registers.
template <int kFirst>
void addProducts(const OverpotentialSweep::Block& factor, const BlockColumns& columns,
                 Eigen::Matrix<double, kBaseColumns, kBaseColumns>& total) {
  constexpr int kLanes = 4;
  constexpr int kLinear = kColumnLogC2;
  constexpr int kCount = kLinear + kBaseColumns - kFirst;
  using Lanes = Eigen::Array<double, kLanes, 1>;
  std::array<Lanes, kCount> sums;
  for (auto& sum : sums) sum.setZero();
  for (int k = 0; k < OverpotentialSweep::kBlock; k += kLanes) {
    const Lanes f = factor.segment<kLanes>(k);
    for (int j = 0; j < kCount; ++j)
      sums[j] += f * columns.col(j < kLinear ? j : kFirst + j - kLinear).segment<kLanes>(k).array();
  }
  for (int j = 0; j < kCount; ++j)
    total(kFirst, j < kLinear ? j : kFirst + j - kLinear) += sums[j].sum();
}

/// Products of the columns that depend on the search's point, each with the linear ones and with
/// itself and those after it.
void addBlock(const OverpotentialSweep::Block& weight, const BlockColumns& columns,
              Eigen::Matrix<double, kBaseColumns, kBaseColumns>& total) {
  const auto weighted = [&](int row) { return columns.col(row).array() * weight; };
  addProducts<kColumnLogC2>(weighted(kColumnLogC2), columns, total);
  addProducts<kColumnLogBeta>(weighted(kColumnLogBeta), columns, total);
  addProducts<kColumnInitial>(weighted(kColumnInitial), columns, total);
  addProducts<kColumnTarget>(weighted(kColumnTarget), columns, total);
}

}  // namespace

BaseNormalEquations::BaseNormalEquations(const std::vector<Sample>& samples, double i0)
    : size_(static_cast<Eigen::Index>(samples.size())),
      sweep_(samples.size(), i0, [&](std::size_t n) { return samples[n].held; }) {
  const Eigen::Index blocks = sweep_.blocks();
  for (auto* padded : {&discharge_, &charge_, &voltage_, &weight_})
    padded->setZero(OverpotentialSweep::kBlock, blocks);
  for (const auto& sample : samples) offset_ += sample.voltage / static_cast<double>(size_);
  for (Eigen::Index n = 0; n < size_; ++n) {
    discharge_.data()[n] = samples[n].discharge;
    charge_.data()[n] = samples[n].charge;
    voltage_.data()[n] = samples[n].voltage - offset_;
    weight_.data()[n] = samples[n].weight;
  }
  linear_ << (discharge_.square() * weight_).sum(), (discharge_ * charge_ * weight_).sum(),
      (discharge_ * weight_).sum(), 0.0, (charge_.square() * weight_).sum(),
      (charge_ * weight_).sum(), 0.0, 0.0, weight_.sum();
  linear_.triangularView<Eigen::StrictlyLower>() = linear_.transpose();
}

void BaseNormalEquations::fill(Eigen::Index block, const OverpotentialSweep::States& states,
                               BlockColumns& columns) const {
  columns.col(kColumnDischarge) = discharge_.col(block);
  columns.col(kColumnCharge) = charge_.col(block);
  columns.col(kColumnOne).setOnes();
  columns.col(kColumnLogC2) = states.d_log_c2;
  columns.col(kColumnLogBeta) = states.d_log_beta;
  columns.col(kColumnInitial) = states.d_initial;
  columns.col(kColumnTarget) = voltage_.col(block) - states.u_c2;
}

BaseSums BaseNormalEquations::sums(const OverpotentialSweep::Point& point) const {
  BaseSums total;
  total.weighted.setZero();
  BlockColumns columns;
  sweep_.run(point, [&](Eigen::Index block, const OverpotentialSweep::States& states) {
    fill(block, states, columns);
    addBlock(weight_.col(block), columns, total.weighted);
  });
  constexpr int kLinear = kColumnLogC2;
  auto& sums = total.weighted;
  sums.bottomRightCorner<kBaseColumns - kLinear, kBaseColumns - kLinear>()
      .triangularView<Eigen::StrictlyLower>() =
      sums.bottomRightCorner<kBaseColumns - kLinear, kBaseColumns - kLinear>().transpose();
  sums.topRightCorner<kLinear, kBaseColumns - kLinear>() =
      sums.bottomLeftCorner<kBaseColumns - kLinear, kLinear>().transpose();
  sums.topLeftCorner<kLinear, kLinear>() = linear_;
  return total;
}

Eigen::Matrix<double, kBaseColumns, 1> BaseNormalEquations::means(
    const OverpotentialSweep::Point& point) const {
  Eigen::Matrix<double, kBaseColumns, 1> total = Eigen::Matrix<double, kBaseColumns, 1>::Zero();
  BlockColumns columns;
  sweep_.run(point, [&](Eigen::Index block, const OverpotentialSweep::States& states) {
    fill(block, states, columns);
    const Block present = (weight_.col(block) > 0.0).cast<double>();
    total.noalias() += columns.transpose() * present.matrix();
  });
  return total / std::max((weight_ > 0.0).cast<double>().sum(), 1.0);
}

BaseNormalEquations::Columns BaseNormalEquations::columns(
    const OverpotentialSweep::Point& point) const {
  Columns all(sweep_.blocks() * OverpotentialSweep::kBlock, kBaseColumns);
  BlockColumns columns;
  sweep_.run(point, [&](Eigen::Index block, const OverpotentialSweep::States& states) {
    fill(block, states, columns);
    all.middleRows<OverpotentialSweep::kBlock>(block * OverpotentialSweep::kBlock) = columns;
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
