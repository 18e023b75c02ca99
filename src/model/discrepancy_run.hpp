#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "model/discrepancy_model.hpp"
#include "regressor_kernel.hpp"

namespace battery_sof {

/// Memory of a discrepancy model at a simulation's beginning, in arithmetic S: of the regressors,
/// those they share, then s [V].
/// @param memory as Simulation::regressorMemory(); empty: it begins with the simulation.
template <typename S>
std::vector<S> firstRegressorMemory(const DiscrepancyModel& discrepancy,
                                    std::vector<double> memory) {
  if (memory.empty()) {
    memory = freshRegressorStates(discrepancy.regressors);
    memory.push_back(discrepancy.base_change[kBaseDirections - 1]);
  }
  if (memory.size() != discrepancy.memorySize())
    throw std::invalid_argument("a discrepancy model's memory has " +
                                std::to_string(memory.size()) + " numbers, expected " +
                                std::to_string(discrepancy.memorySize()));
  return std::vector<S>(memory.begin(), memory.end());
}

/// A discrepancy model along a simulation, in arithmetic S. Its memory is the caller's, see
/// firstRegressorMemory().
template <typename S>
class DiscrepancyRun {
 public:
  /// The battery over one interval, as the discrepancy sees it.
  struct Interval {
    RegressorInputOf<S> moment;  // overpotential: at the end
    S before;                    // [V], u_c2 at the beginning
    S conductance, capacitance;  // [1/Ohm], [F], of the double layer in the middle
  };

  explicit DiscrepancyRun(std::shared_ptr<const DiscrepancyModel> discrepancy)
      : discrepancy_(std::move(discrepancy)) {
    values_.assign(discrepancy_->regressors.size(), S(0.0));
    for (const Regressor& regressor : discrepancy_->regressors) {
      std::size_t part = 0;
      while (discrepancy_->parts[part].mechanism != regressor.mechanism) ++part;
      part_.push_back(part);
    }
  }

  /// Moves over an interval. @param factors one a part.  @param memory updated.
  void advance(const Interval& interval, const S* factors, std::vector<S>& memory) {
    RegressorKernel<S>{discrepancy_->regressors, discrepancy_->context, shares_, memory.data()}
        .advance(interval.moment, values_.data());
    moveCircuit(interval, memory.back());
    voltage_ = S(memory.back() + circuitAt(interval.moment.current) + sumOf(factors));
  }

  const S& voltage() const { return voltage_; }  ///< [V], after the last interval
  /// [V], by which regressors were held inside their ranges then
  double beyond() const { return beyond_; }
  void setBeyond(double beyond) { beyond_ = beyond; }

 private:
  /// Exact step of the linearised double layer under what it answers to, all held at the interval's
  /// middle.
  void moveCircuit(const Interval& interval, S& moved_by) const {
    const double duration = interval.moment.duration;
    if (duration <= 0.0) return;
    const Eigen::VectorXd& d = discrepancy_->base_change;
    const S& end = interval.moment.overpotential;
    const S moved = S((end - interval.before) * (1.0 / duration)),
            mean = S((end + interval.before) * 0.5);
    const S rate = S(interval.conductance / interval.capacitance);
    const double kept = std::exp(-duration * valueOf(rate));
    const S decay = mapped(rate, kept, -duration * kept);
    const S settled = S(-(moved / rate) * d[kDirectionC2] - mean * d[kDirectionBeta]);
    moved_by = S(settled + (moved_by - settled) * decay);
  }

  S circuitAt(const S& current) const {
    const Eigen::VectorXd& d = discrepancy_->base_change;
    return S(current * (valueOf(current) < 0.0 ? d[0] : d[1]) + d[kDirectionUDc]);
  }

  S sumOf(const S* factors) {
    S sum(0.0);
    beyond_ = 0.0;
    for (std::size_t k = 0; k < values_.size(); ++k) {
      const Eigen::Index j = k;
      const double weight = discrepancy_->weight[j] / discrepancy_->scale[j];
      if (weight == 0.0) continue;
      const double value = valueOf(values_[k]),
                   inside = std::clamp(value, discrepancy_->lower[j], discrepancy_->upper[j]);
      const bool held = value != inside && !isUnbounded(discrepancy_->regressors[k].kind);
      if (held) beyond_ += std::abs(weight * (value - inside));
      const S x = held ? S(inside) : values_[k];
      sum = S(sum + factors[part_[k]] * S((x - discrepancy_->centre[j]) * weight));
    }
    return sum;
  }

  static constexpr Eigen::Index kDirectionC2 = 2, kDirectionBeta = 3, kDirectionUDc = 4;

  std::shared_ptr<const DiscrepancyModel> discrepancy_;
  std::vector<S> values_;
  std::vector<std::size_t> part_;  // of every regressor
  LowPassShares shares_;
  double beyond_ = 0.0;
  S voltage_ = S(0.0);
};

}  // namespace battery_sof
