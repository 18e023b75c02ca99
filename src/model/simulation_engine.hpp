#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "battery_sof/model/simulation.hpp"
#include "double_layer.hpp"

namespace battery_sof {

/// What a Simulation is in one of its arithmetics.
class Simulation::Engine {
 public:
  virtual ~Engine() = default;
  virtual std::unique_ptr<Engine> clone() const = 0;
  virtual void advance(const DriveStep& step) = 0;
  virtual double advanceAtVoltage(double voltage, double duration, double most_current) = 0;
  virtual double voltage() const = 0;
  virtual const double* voltageDerivatives() const = 0;
  virtual const double* currentDerivatives() const = 0;
  virtual double time() const = 0;
  virtual Eigen::VectorXd state() const = 0;
  virtual Eigen::MatrixXd stateDerivatives() const = 0;
  virtual Eigen::Index lanes() const = 0;
};

inline const double* derivativesOf(const double&) { return nullptr; }
template <int N>
const double* derivativesOf(const Dual<N>& x) {
  return x.derivatives().data();
}

/// A number with its row of the seeds.
inline double seeded(double value, const Eigen::Ref<const Eigen::MatrixXd>&, Eigen::Index, double) {
  return value;
}
template <int N>
Dual<N> seeded(double value, const Eigen::Ref<const Eigen::MatrixXd>& seeds, Eigen::Index row,
               const Dual<N>&) {
  Dual<N> x(value);
  if (seeds.cols() > 0) x.derivatives().head(seeds.cols()) = seeds.row(row).transpose();
  return x;
}

template <typename S>
class EngineOf final : public Simulation::Engine {
 public:
  EngineOf(const BatteryModel& model, const ModelPoint& start,
           const Eigen::Ref<const Eigen::MatrixXd>& seeds)
      : lanes_(seeds.cols()),
        time_(start.time),
        reference_time_(start.reference_time),
        model_(std::make_shared<const BatteryModel>(model)),
        members_(membersOf(model)),
        layer_(layerOf(members_)) {
    const Eigen::Index parameters = model.parameterCount();
    for (Eigen::Index j = 0; j < parameters; ++j)
      p_.push_back(seeded(start.parameters[j], seeds, j, S()));
    for (Eigen::Index j = 0; j < model.stateCount(); ++j)
      x_.push_back(seeded(start.state[j], seeds, parameters + j, S()));
    voltage_ = S(0.0);
    terminal_ = S(0.0);
    source_current_ = S(0.0);
  }
  std::unique_ptr<Engine> clone() const override { return std::make_unique<EngineOf>(*this); }

  void advance(const DriveStep& step) override {
    S held(step.held), end(step.current);
    for (const Member& member : members_)
      if (member.effect->hooks.sense)
        kernel(member).sense(&p_[member.parameter], step, held, end);
    pass(held, end, step.duration, step.slope, step.time);
  }

  double advanceAtVoltage(double voltage, double duration, double most_current) override {
    const double end_time = time_ + duration;
    const double i = currentFor(voltage, duration, most_current);
    const double begin_time = time_;
    const std::vector<S> begin = x_;
    const DoubleLayer<S> layer = layer_;
    source_current_ = S(i);
    pass(source_current_, source_current_, duration, 0.0, end_time);
    if (lanes_ > 0 && i < most_current) {
      source_current_ = S(i - (terminal_ - valueOf(terminal_)) / probe_slope_);
      x_ = begin;
      layer_ = layer;
      time_ = begin_time;
      pass(source_current_, source_current_, duration, 0.0, end_time);
    }
    return i;
  }

  double voltage() const override { return valueOf(voltage_); }
  const double* voltageDerivatives() const override { return derivativesOf(voltage_); }
  const double* currentDerivatives() const override { return derivativesOf(source_current_); }
  double time() const override { return time_; }
  Eigen::Index lanes() const override { return lanes_; }
  Eigen::VectorXd state() const override {
    Eigen::VectorXd values(static_cast<Eigen::Index>(x_.size()));
    for (std::size_t j = 0; j < x_.size(); ++j) values[static_cast<Eigen::Index>(j)] = valueOf(x_[j]);
    return values;
  }
  Eigen::MatrixXd stateDerivatives() const override {
    Eigen::MatrixXd slopes(static_cast<Eigen::Index>(x_.size()), lanes_);
    for (std::size_t j = 0; j < x_.size(); ++j)
      for (Eigen::Index k = 0; k < lanes_; ++k)
        slopes(static_cast<Eigen::Index>(j), k) = derivativesOf(x_[j])[k];
    return slopes;
  }

  /// One interval under a held current of the battery itself.
  void pass(const S& held, const S& end, double duration, double slope, double end_time) {
    const int pieces = steps_finely_ && duration > kFineStep
                           ? static_cast<int>(std::min(std::ceil(duration / kFineStep), kMostPieces))
                           : 1;
    const double piece = duration / pieces;
    for (int k = 1; k <= pieces; ++k) {
      if (duration > 0.0) passPiece(held, piece, end_time - duration + piece * k);
    }
    time_ = end_time;
    const Present<S> present = presentAt(end_time);
    const Instant<S> instant{end, slope, duration, present};
    const S r = valueOf(end) < 0.0 ? present.r_discharge : present.r_charge;
    terminal_ = S(present.u_dc + x_[0] + r * end);
    for (const Member& member : members_)
      if (member.effect->hooks.voltage)
        terminal_ = S(terminal_ + kernel(member).voltage(&p_[member.parameter], stateOf(member), instant));
    voltage_ = terminal_;
    for (const Member& member : members_)
      if (member.effect->hooks.show)
        kernel(member).show(&p_[member.parameter], stateOf(member), instant, voltage_);
  }

  const S& terminal() const { return terminal_; }
  DoubleLayer<S>& layer() { return layer_; }

 private:
  static constexpr double kFineStep = 0.1;     // [s]
  static constexpr double kMostPieces = 10000;  // of one interval: beyond it is a gap of hours, at rest

  struct Member {
    const Effect* effect;
    int parameter, state;
  };

  static std::vector<Member> membersOf(const BatteryModel& model) {
    std::vector<Member> members;
    for (std::size_t k = 0; k < model.effects().size(); ++k)
      for (const Effect& effect : allEffects())
        if (effect.info.id == model.effects()[k])
          members.push_back({&effect, static_cast<int>(model.firstParameter(k)),
                             static_cast<int>(model.firstState(k))});
    return members;
  }

  DoubleLayer<S> layerOf(const std::vector<Member>& members) {
    std::vector<BoundEffect> side;
    BoundEffect activity{nullptr, 0};
    for (const Member& member : members) {
      const EffectHooks& hooks = member.effect->hooks;
      if (hooks.side_current) side.push_back({member.effect, member.parameter});
      if (hooks.activity) {
        activity = {member.effect, member.parameter};
        activity_state_ = member.state;
      }
      if (hooks.is_ladder) ladder_state_ = member.state;
      if (hooks.steps_finely) steps_finely_ = true;
    }
    return DoubleLayer<S>(side, activity.effect ? &activity : nullptr, ladder_state_ >= 0);
  }

  static const EffectKernel<S>& kernel(const Member& member) { return kernelOf(*member.effect, S()); }
  S* stateOf(const Member& member) {
    return member.state < static_cast<int>(x_.size()) ? &x_[member.state] : nullptr;
  }

  Present<S> presentAt(double time) {
    Present<S> present{p_[kRowRDischarge], p_[kRowRCharge], p_[kRowC2], p_[kRowBeta], p_[kRowUDc],
                       S(BaseParameters{}.i0), S(BaseParameters{}.alpha), S(1.0), S(0.0), S(0.0),
                       time - reference_time_};
    for (const Member& member : members_)
      if (member.effect->hooks.adapt)
        kernel(member).adapt(&p_[member.parameter], stateOf(member), present);
    return present;
  }

  void passPiece(const S& held, double duration, double end_time) {
    const double middle = end_time - 0.5 * duration;
    if (steps_finely_) advanceMembers(held, 0.5 * duration, x_[0], presentAt(middle), true);
    const Present<S> present = presentAt(middle);
    const S before = x_[0];
    layer_.advance(p_.data(), present, held, duration, x_[0],
                   activity_state_ >= 0 ? &x_[activity_state_] : nullptr,
                   ladder_state_ >= 0 ? &x_[ladder_state_] : nullptr);
    const S mean = S(0.5 * (before + x_[0]));
    advanceMembers(held, duration, mean, present, false);
    if (steps_finely_) advanceMembers(held, 0.5 * duration, x_[0], present, true);
  }

  void advanceMembers(const S& held, double duration, const S& u_c2, const Present<S>& present,
                      bool fine) {
    const Passage<S> passage{held, duration, u_c2, present};
    for (const Member& member : members_)
      if (member.effect->hooks.advance && member.effect->hooks.steps_finely == fine)
        kernel(member).advance(&p_[member.parameter], stateOf(member), passage);
  }

  /// The same battery in the arithmetic of a solver for the current.
  EngineOf<Slope> probe() const {
    ModelPoint here;
    here.time = time_;
    here.reference_time = reference_time_;
    here.parameters.resize(static_cast<Eigen::Index>(p_.size()));
    for (std::size_t j = 0; j < p_.size(); ++j)
      here.parameters[static_cast<Eigen::Index>(j)] = valueOf(p_[j]);
    here.state = state();
    EngineOf<Slope> same(*model_, here, Eigen::MatrixXd());
    same.layer().suggestStep(layer_.suggestedStep());
    return same;
  }

  /// Newton's method inside a bracket; the terminal voltage rises with the current.
  double currentFor(double voltage, double duration, double most_current) {
    const EngineOf<Slope> begin = probe();
    const auto short_of = [&](double i) {
      EngineOf<Slope> trial = begin;
      const Slope current(i, Eigen::Matrix<double, 1, 1>::Ones());
      trial.pass(current, current, duration, 0.0, time_ + duration);
      probe_slope_ = trial.terminal().derivatives()[0];
      return trial.terminal().value() - voltage;
    };
    if (short_of(most_current) <= 0.0) return most_current;
    double low = -HUGE_VAL, high = most_current;
    double i = std::min(valueOf(source_current_), most_current);
    for (int k = 0; k < 100; ++k) {
      const double excess = short_of(i);
      (excess > 0.0 ? high : low) = i;
      double next = i - excess / probe_slope_;
      if (!(next > low && next < high)) next = 0.5 * (std::max(low, high - 1e4) + high);
      const bool done = std::abs(next - i) < 1e-9;
      i = next;
      if (done) break;
    }
    return i;
  }

  Eigen::Index lanes_;
  double time_, reference_time_;
  int activity_state_ = -1, ladder_state_ = -1;
  bool steps_finely_ = false;
  std::shared_ptr<const BatteryModel> model_;
  std::vector<Member> members_;
  DoubleLayer<S> layer_;
  std::vector<S> p_, x_;
  S voltage_, terminal_, source_current_;
  double probe_slope_ = 1.0;  // [Ohm], d terminal voltage / d held current
};

}  // namespace battery_sof
