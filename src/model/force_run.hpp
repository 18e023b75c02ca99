#pragma once

#include <memory>
#include <vector>

#include "battery_sof/model/learned_force.hpp"
#include "force_kernel.hpp"

namespace battery_sof {

/// A learnt force along a simulation, in arithmetic S.
template <typename S>
class ForceRun {
 public:
  /// The battery over one interval, as the force sees it.
  struct Interval {
    ForceMomentOf<S> moment;      // overpotential: at the end
    S before;                     // [V], u_c2 at the beginning
    S conductance, capacitance;   // [1/Ohm], [F], of the double layer in the middle
  };

  ForceRun(std::shared_ptr<const LearnedForce> force, const std::vector<double>& memory) : force_(std::move(force)) {
    std::vector<double> state = memory;
    if (state.empty()) {
      state = freshColumnStates(force_->columns);
      state.push_back(force_->base_change[kBaseDirections - 1]);
    }
    if (state.size() != force_->memorySize())
      throw std::invalid_argument("a learnt force's memory has " + std::to_string(state.size()) + " numbers, expected " +
                                  std::to_string(force_->memorySize()));
    for (const double x : state) state_.push_back(S(x));
    values_.assign(force_->columns.size(), S(0.0));
    for (const ForceColumn& column : force_->columns) {
      std::size_t part = 0;
      while (force_->parts[part].family != column.family) ++part;
      part_.push_back(part);
    }
  }

  /// Moves over an interval. @param factors one a part.
  void advance(const Interval& interval, const S* factors) {
    if (interval.moment.duration != share_duration_) {
      share_duration_ = interval.moment.duration;
      takeShares(force_->columns, share_duration_, share_);
    }
    ColumnKernel<S>{force_->columns, force_->context, share_, state_.data()}.advance(interval.moment, values_.data());
    moveCircuit(interval);
    voltage_ = S(state_.back() + circuitAt(interval.moment.current) + sumOf(factors));
  }

  const S& voltage() const { return voltage_; }  ///< [V], after the last interval
  double beyond() const { return beyond_; }      ///< [V], by which columns were held inside their ranges then
  std::vector<S>& state() { return state_; }
  const std::vector<S>& state() const { return state_; }
  void setBeyond(double beyond) { beyond_ = beyond; }

 private:
  /// Exact step of the linearised double layer under what it answers to, all held at the interval's middle.
  void moveCircuit(const Interval& interval) {
    const double duration = interval.moment.duration;
    if (duration <= 0.0) return;
    const Eigen::VectorXd& d = force_->base_change;
    const S& end = interval.moment.overpotential;
    const S moved = S((end - interval.before) * (1.0 / duration)), mean = S((end + interval.before) * 0.5);
    const S rate = S(interval.conductance / interval.capacitance);
    const double kept = std::exp(-duration * valueOf(rate));
    const S decay = mapped(rate, kept, -duration * kept);
    const S settled = S(-(moved / rate) * d[kDirectionC2] - mean * d[kDirectionBeta]);
    state_.back() = S(settled + (state_.back() - settled) * decay);
  }

  S circuitAt(const S& current) const {
    const Eigen::VectorXd& d = force_->base_change;
    return S(current * (valueOf(current) < 0.0 ? d[0] : d[1]) + d[kDirectionUDc]);
  }

  S sumOf(const S* factors) {
    S sum(0.0);
    beyond_ = 0.0;
    for (std::size_t k = 0; k < values_.size(); ++k) {
      const auto j = static_cast<Eigen::Index>(k);
      const double weight = force_->weight[j] / force_->scale[j];
      if (weight == 0.0) continue;
      const double value = valueOf(values_[k]), inside = std::clamp(value, force_->lower[j], force_->upper[j]);
      const bool held = value != inside && !isUnbounded(force_->columns[k].kind);
      if (held) beyond_ += std::abs(weight * (value - inside));
      const S x = held ? S(inside) : values_[k];
      sum = S(sum + factors[part_[k]] * S((x - force_->centre[j]) * weight));
    }
    return sum;
  }

  static constexpr Eigen::Index kDirectionC2 = 2, kDirectionBeta = 3, kDirectionUDc = 4;

  std::shared_ptr<const LearnedForce> force_;
  std::vector<S> state_;  // of the columns, those they share, then s [V]
  std::vector<S> values_;
  std::vector<std::size_t> part_;  // of every column
  std::vector<double> share_;
  double share_duration_ = -1.0, beyond_ = 0.0;
  S voltage_ = S(0.0);
};

}  // namespace battery_sof
