#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "bound_composition.hpp"
#include "effects/effect_definition.hpp"

namespace battery_sof {

template <typename S>
Eigen::VectorXd valuesOf(const std::vector<S>& numbers) {
  Eigen::VectorXd values(numbers.size());
  for (std::size_t j = 0; j < numbers.size(); ++j) values[j] = valueOf(numbers[j]);
  return values;
}

/// A number with its row of the seeds.
inline double seeded(double value, const Eigen::Ref<const Eigen::MatrixXd>&, Eigen::Index, double) {
  return value;
}
inline Slope seeded(double value, const Eigen::Ref<const Eigen::MatrixXd>&, Eigen::Index,
                    const Slope&) {
  return value;
}
inline Dual seeded(double value, const Eigen::Ref<const Eigen::MatrixXd>& seeds, Eigen::Index row,
                   const Dual&) {
  return seeds.cols() > 0 ? Dual(value, seeds.row(row)) : Dual(value);
}

/// Below it nothing has a meaning; further down, numbers that fade away get stuck where the
/// processor is slow.
inline constexpr double kFaded = 1e-200;

inline void dropFaded(double& x) {
  if (std::abs(x) < kFaded) x = 0.0;
}
template <typename S>
void dropFaded(S& x) {
  dropFaded(x.value());
  x.changeDerivatives([](double& derivative) { dropFaded(derivative); });
}

/**
 * @brief A composition's parameters in arithmetic S and the calls of its effects' hooks, each in
 * the members' order.
 *
 * States are the caller's: `x` is all of them, in the composition's order.
 */
template <typename S>
class ComposedEffects {
 public:
  ComposedEffects(std::shared_ptr<const BoundComposition> bound, const Eigen::VectorXd& parameters,
                  double reference_time, const Eigen::Ref<const Eigen::MatrixXd>& seeds)
      : bound_(std::move(bound)), reference_time_(reference_time) {
    for (Eigen::Index j = 0; j < parameters.size(); ++j)
      p_.push_back(seeded(parameters[j], seeds, j, S()));
    present_ = bareModel();
  }

  const std::shared_ptr<const BoundComposition>& shared() const { return bound_; }
  const BoundComposition& bound() const { return *bound_; }
  const std::vector<S>& parameters() const { return p_; }
  double referenceTime() const { return reference_time_; }

  /// Turns measured currents into the battery's.
  void sense(const InputStep& step, S& held, S& end) const {
    for (const Member& member : bound_->members)
      if (member.effect->hooks.sense) kernel(member).sense(ownOf(member), step, held, end);
  }

  /// The base model as effects leave it; until the next call.
  const Present<S>& presentAt(double time, const std::vector<S>& x) {
    if (bound_->adapts) present_ = bareModel();
    present_.time = time - reference_time_;
    for (const Member& member : bound_->members)
      if (member.adapts) kernel(member).adapt(ownOf(member), stateOf(member, x), present_);
    return present_;
  }
  /// As the last presentAt() returned it.
  const Present<S>& present() const { return present_; }

  /// @param fine of those that step finely, else of the others.
  void advance(const Passage<S>& passage, bool fine, std::vector<S>& x) const {
    for (const Member& member : bound_->members)
      if (member.effect->hooks.advance && member.effect->hooks.steps_finely == fine)
        kernel(member).advance(ownOf(member), stateOf(member, x), passage);
  }

  /// @return `current` less what goes past the double layer's reaction at u_c2 [A].
  S lessSideCurrents(S current, const S& u_c2) const {
    for (const Member& member : bound_->members)
      if (member.effect->hooks.side_current)
        current = S(current - kernel(member).sideCurrent(ownOf(member), u_c2, present_));
    return current;
  }

  /// Adds the effects' voltages in series [V].
  void addVoltages(const Instant<S>& instant, const std::vector<S>& x, S& voltage) const {
    for (const Member& member : bound_->members)
      if (member.effect->hooks.voltage)
        voltage = S(voltage + kernel(member).voltage(ownOf(member), stateOf(member, x), instant));
  }

  /// Turns the terminal voltage into what the channel shows.
  void show(const Instant<S>& instant, std::vector<S>& x, S& voltage) const {
    for (const Member& member : bound_->members)
      if (member.effect->hooks.show)
        kernel(member).show(ownOf(member), stateOf(member, x), instant, voltage);
  }

 private:
  using Member = BoundComposition::Member;

  static const EffectKernel<S>& kernel(const Member& member) {
    return kernelOf(*member.effect, S());
  }
  const S* ownOf(const Member& member) const { return p_.data() + member.parameter; }
  template <typename States>
  static auto stateOf(const Member& member, States& x) -> decltype(x.data()) {
    return member.state < static_cast<int>(x.size()) ? &x[member.state] : nullptr;
  }

  Present<S> bareModel() const {
    return {p_[kRowRDischarge], p_[kRowRCharge], p_[kRowC2], p_[kRowBeta], p_[kRowUDc]};
  }

  std::shared_ptr<const BoundComposition> bound_;
  double reference_time_;
  std::vector<S> p_;
  Present<S> present_;
};

}  // namespace battery_sof
