#include "battery_sof/identify/base_normal_equations.hpp"

#include <algorithm>

namespace battery_sof {
namespace {

std::vector<HeldCurrent> heldOf(const std::vector<BaseNormalEquations::Sample>& samples) {
  std::vector<HeldCurrent> held;
  held.reserve(samples.size());
  for (const auto& sample : samples) held.push_back(sample.held);
  return held;
}

}  // namespace

BaseNormalEquations::BaseNormalEquations(const std::vector<Sample>& samples, double i0)
    : size_(static_cast<Eigen::Index>(samples.size())), sweep_(heldOf(samples), i0) {
  const Eigen::Index blocks = sweep_.blocks();
  for (auto* padded : {&discharge_, &charge_, &voltage_, &weight_, &present_})
    padded->setZero(OverpotentialSweep::kBlock, blocks);
  for (const auto& sample : samples) offset_ += sample.voltage / static_cast<double>(size_);
  for (Eigen::Index n = 0; n < size_; ++n) {
    discharge_.data()[n] = samples[n].discharge;
    charge_.data()[n] = samples[n].charge;
    voltage_.data()[n] = samples[n].voltage - offset_;
    weight_.data()[n] = samples[n].weight;
    present_.data()[n] = samples[n].weight > 0.0 ? 1.0 : 0.0;
  }
  unmasked_ = std::max(present_.sum(), 1.0);
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
  total.mean.setZero();
  BlockColumns columns, weighted;
  sweep_.run(point, [&](Eigen::Index block, const OverpotentialSweep::States& states) {
    fill(block, states, columns);
    weighted = (columns.array().colwise() * weight_.col(block)).matrix();
    total.weighted.noalias() += columns.transpose() * weighted;
    total.mean.noalias() += columns.transpose() * present_.col(block).matrix();
  });
  total.mean /= unmasked_;
  return total;
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
    // The state in the middle stands for the mean of the state: from middle to middle the current is held.
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
