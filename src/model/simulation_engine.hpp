#pragma once

#include <cmath>
#include <memory>
#include <type_traits>
#include <vector>

#include "battery_sof/model/simulation.hpp"
#include "force_run.hpp"
#include "narrow_layer.hpp"
#include "source_search.hpp"

namespace battery_sof {

/// What a Simulation is in one of its arithmetics.
class Simulation::Engine {
 public:
  virtual ~Engine() = default;
  virtual std::unique_ptr<Engine> clone() const = 0;
  virtual void advance(const DriveStep& step) = 0;
  virtual double advanceAtVoltage(double voltage, double duration, double most_current) = 0;
  virtual void followVoltage(const DriveStep& step, double voltage) = 0;
  virtual double resistanceOver(double current, double duration) = 0;
  virtual double currentError() const = 0;
  virtual const double* currentErrorDerivatives() const = 0;
  virtual double voltage() const = 0;
  virtual const double* voltageDerivatives() const = 0;
  virtual const double* currentDerivatives() const = 0;
  virtual double time() const = 0;
  virtual Eigen::VectorXd state() const = 0;
  virtual Eigen::MatrixXd stateDerivatives() const = 0;
  virtual std::vector<double> forceMemory() const = 0;
  virtual double beyondLearned() const = 0;
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

/// Below it nothing has a meaning; further down, numbers that fade away get stuck where the processor is slow.
inline constexpr double kFaded = 1e-200;

inline void dropFaded(double& x) {
  if (std::abs(x) < kFaded) x = 0.0;
}
template <int N>
void dropFaded(Dual<N>& x) {
  dropFaded(x.value());
  x.derivatives() = (x.derivatives().array().abs() < kFaded).select(0.0, x.derivatives());
}

/// Derivatives that a number carries.
template <typename S>
struct Width {
  static constexpr int value = 0;
};
template <int N>
struct Width<Dual<N>> {
  static constexpr int value = N;
};

template <typename S>
class EngineOf final : public Simulation::Engine {
 public:
  EngineOf(const BatteryModel& model, const ModelPoint& start,
           const Eigen::Ref<const Eigen::MatrixXd>& seeds)
      : lanes_(seeds.cols()),
        time_(start.time),
        reference_time_(start.reference_time),
        model_(std::make_shared<const BatteryModel>(model)),
        members_(membersOf(model)) {
    const Eigen::Index parameters = model.parameterCount();
    for (Eigen::Index j = 0; j < parameters; ++j)
      p_.push_back(seeded(start.parameters[j], seeds, j, S()));
    for (Eigen::Index j = 0; j < model.stateCount(); ++j)
      x_.push_back(seeded(start.state[j], seeds, parameters + j, S()));
    findHooks();
    if (model.force()) force_ = std::make_unique<ForceRun<S>>(model.force(), start.force_memory);
    layer_ = layerFor(lanesOfLayer(seeds));
    present_ = bareModel();
  }
  EngineOf(const EngineOf& other)
      : Engine(),
        lanes_(other.lanes_),
        time_(other.time_),
        reference_time_(other.reference_time_),
        activity_state_(other.activity_state_),
        ladder_state_(other.ladder_state_),
        force_parameter_(other.force_parameter_),
        steps_finely_(other.steps_finely_),
        adapts_(other.adapts_),
        is_wide_(other.is_wide_),
        limits_reaction_(other.limits_reaction_),
        longest_piece_(other.longest_piece_),
        intervals_(other.intervals_),
        model_(other.model_),
        members_(other.members_),
        layer_(other.layer_->clone()),
        force_(other.force_ ? std::make_unique<ForceRun<S>>(*other.force_) : nullptr),
        p_(other.p_),
        x_(other.x_),
        present_(other.present_),
        voltage_(other.voltage_),
        terminal_(other.terminal_),
        source_current_(other.source_current_),
        current_error_(other.current_error_),
        reaction_(other.reaction_),
        source_trend_(other.source_trend_),
        source_move_(other.source_move_),
        source_resistance_(other.source_resistance_),
        source_bend_(other.source_bend_),
        last_current_(other.last_current_) {}  // the probe is work space: a copy makes its own
  EngineOf& operator=(const EngineOf&) = delete;
  std::unique_ptr<Engine> clone() const override { return std::make_unique<EngineOf>(*this); }

  void advance(const DriveStep& step) override {
    S held(step.held), end(step.current);
    for (const Member& member : members_)
      if (member.effect->hooks.sense)
        kernel(member).sense(&p_[member.parameter], step, held, end);
    pass(held, end, step.duration, step.slope, step.time, {S(step.held), S(step.current), step.gap});
    source_trend_ = source_move_ = 0.0;
  }

  double advanceAtVoltage(double voltage, double duration, double most_current) override {
    return advanceTo(S(voltage), duration, most_current);
  }

  /// As advanceAtVoltage(), to a voltage that may follow the lanes itself.
  double advanceTo(const S& voltage, double duration, double most_current) {
    widen();  // the current's lanes reach the double layer
    if (limits_reaction_ && activity_state_ < 0 && ladder_state_ < 0 && !steps_finely_ &&
        stepAtSource(voltage, duration, most_current))
      return valueOf(source_current_);
    return advanceBySearch(voltage, duration, most_current);
  }

  /// The current over an interval as a learnt force sees it: the measured one.
  struct Seen {
    S held, end;
    bool gap;
  };

  void followVoltage(const DriveStep& step, double voltage) override {
    S held(step.held), shown(step.current);
    for (const Member& member : members_)
      if (member.effect->hooks.sense)
        kernel(member).sense(&p_[member.parameter], step, held, shown);
    if (step.duration <= 0.0) {
      pass(held, shown, 0.0, 0.0, step.time);
      source_current_ = shown;
      current_error_ = S(0.0);
      return;
    }
    if (step.missed > 0.0) discharge(step.missed);
    const double ramp = step.gap ? std::min(step.duration, kRampAfterGap) : step.duration;
    if (ramp < step.duration) {
      pass(S(0.0), S(0.0), step.duration - ramp, 0.0, step.time - ramp);
      source_current_ = S(0.0);
      source_trend_ = source_move_ = 0.0;
    }
    // Before its first step a simulation has shown no voltage to ramp from.
    const S from = valueOf(terminal_) != 0.0 ? terminal_ : S(voltage);
    const double parts = std::clamp(std::ceil(ramp / kLongestHold - 1e-9), 1.0, kMostHolds);
    for (double k = 1.0; k <= parts; ++k)
      advanceTo(S(from + (voltage - from) * (k / parts)), ramp / parts, kMostCurrent);
    time_ = step.time;
    current_error_ = S(shown - source_current_);
  }

  /**
   * @brief One implicit Euler step of double layer and effects behind a source of the terminal voltage.
   *
   * The current is eliminated: what the other effects and the ohmic resistance make of it is affine in it, or is made so by
   * Newton's method. @return false, nothing moved, when the current would exceed most_current or is not found.
   */
  bool stepAtSource(const S& voltage, double duration, double most_current) {
    const double end_time = time_ + duration;
    const Present<S> present = presentAt(end_time - 0.5 * duration);
    const double before = valueOf(x_[0]);
    EngineOf<Slope>& slopes = probe();
    const Present<Slope> slope_present = slopes.presentAt(end_time - 0.5 * duration);
    double i = valueOf(source_current_);
    SourceStep step;
    double resistance = 0.0;
    bool found = false;
    for (int k = 0; k < 20 && !found; ++k) {
      const Slope others = slopes.othersVoltage(Slope(i, Eigen::Matrix<double, 1, 1>::Ones()), duration,
                                                Slope(k > 0 ? step.u : before), slope_present);
      resistance = others.derivatives()[0];
      step = layer_->atSource(p_.data(), present, valueOf(voltage) - others.value() + resistance * i, resistance, duration, before);
      found = std::abs(step.current - i) < 1e-7 * (1.0 + std::abs(i));
      i = step.current;
    }
    if (!found || i > most_current || !std::isfinite(i)) return false;
    // In arithmetic S one Newton step for (u, i) adds the derivatives: B du - di = -a, du + R di = -b.
    const S held(i), u(step.u);
    const S a = layer_->imbalance(p_.data(), present, held, duration, x_[0], step.u);
    const S b = S(othersVoltage(held, duration, u, present) + u - voltage);
    const double grip = force_ ? 1.0 + slopes.forceSlope(i, duration, step.u, slope_present) : 1.0;  // d(voltage) / du, i held
    const S du = S((a + b * (1.0 / resistance)) * (-1.0 / (step.slope + grip / resistance)));
    const S mean = S(0.5 * (x_[0] + u + du));
    const S moved = S(u + du - x_[0]);
    source_trend_ = source_move_ = 0.0;
    source_current_ = S(held - (b + grip * du) * (1.0 / resistance));
    last_current_ = valueOf(source_current_);
    const S start = x_[0];
    x_[0] = S(u + du);
    reaction_ = reactionOf(source_current_, moved, mean, duration);
    advanceMembers(source_current_, duration, mean, present, false);
    time_ = end_time;
    moveForce(start, x_[0], duration, {source_current_, source_current_, false}, present);
    show({source_current_, 0.0, duration, presentAt(end_time)});
    return true;
  }

  /// Everything in the terminal voltage but u_c2 after a step under a current; moves nothing.
  S othersVoltage(const S& i, double duration, const S& u, const Present<S>& present) {
    kept_ = x_;
    std::swap(reaction_, kept_reaction_);
    reaction_ = i;
    advanceMembers(i, duration, u, present, false);
    const Instant<S> instant{i, 0.0, duration, present};
    S voltage = S(present.u_dc + ohmic(present, i) * i);
    for (const Member& member : members_)
      if (member.effect->hooks.voltage)
        voltage = S(voltage + kernel(member).voltage(&p_[member.parameter], stateOf(member), instant));
    std::swap(x_, kept_);
    std::swap(reaction_, kept_reaction_);
    return force_ ? S(voltage + forceAfter(i, duration, u, present)) : voltage;
  }
  /// Terminal voltage at an instant, and what the channel makes of it.
  void show(const Instant<S>& instant) {
    terminal_ = S(instant.present.u_dc + x_[0] + ohmic(instant.present, instant.current) * instant.current);
    for (const Member& member : members_)
      if (member.effect->hooks.voltage)
        terminal_ = S(terminal_ + kernel(member).voltage(&p_[member.parameter], stateOf(member), instant));
    if (force_) terminal_ = S(terminal_ + force_->voltage());
    voltage_ = terminal_;
    for (const Member& member : members_)
      if (member.effect->hooks.show)
        kernel(member).show(&p_[member.parameter], stateOf(member), instant, voltage_);
  }
  static const S& ohmic(const Present<S>& present, const S& current) {
    return valueOf(current) < 0.0 ? present.r_discharge : present.r_charge;
  }

  /// Charge that nobody saw flow: it goes into the effects' balances and moves no voltage.
  void discharge(double charge) {
    constexpr double kAtOnce = 1e-9;  // [s]
    reaction_ = S(-charge / kAtOnce);
    advanceMembers(S(0.0), kAtOnce, x_[0], presentAt(time_), false);
  }

  double resistanceOver(double current, double duration) override {
    trail_.clear();
    excessOf(current, 0.0, duration);
    return probe_->terminal_.derivatives()[0];
  }
  double currentError() const override { return valueOf(current_error_); }
  const double* currentErrorDerivatives() const override { return derivativesOf(current_error_); }

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
  std::vector<double> forceMemory() const override {
    std::vector<double> memory;
    if (force_)
      for (const S& x : force_->state()) memory.push_back(valueOf(x));
    return memory;
  }
  double beyondLearned() const override { return force_ ? force_->beyond() : 0.0; }

  /// One interval under a held current of the battery itself.
  void pass(const S& held, const S& end, double duration, double slope, double end_time) {
    pass(held, end, duration, slope, end_time, {held, end, false});
  }
  void pass(const S& held, const S& end, double duration, double slope, double end_time, const Seen& seen) {
    const S before = force_ ? x_[0] : S(0.0);
    last_current_ = valueOf(end);
    for (double done = 0.0; done < duration;) {
      const double piece = pieceOf(duration, done);
      done = done + piece < duration * (1.0 - 1e-12) ? done + piece : duration;
      passPiece(held, piece, end_time - duration + done);
    }
    if (++intervals_ == kFadingLooked) {
      intervals_ = 0;
      for (S& x : x_) dropFaded(x);
    }
    time_ = end_time;
    const Present<S>& present = presentAt(end_time);
    moveForce(before, x_[0], duration, seen, present);
    show({end, slope, duration, present});
  }

 private:
  template <typename T>
  friend class EngineOf;

  static constexpr double kGrowing = 0.005;  // of the time passed
  // A voltage between two samples is a ramp of currents held this long [s], at slow rates at most so many.
  static constexpr double kLongestHold = 0.5, kMostHolds = 8.0;
  static constexpr double kMostPieces = 8.0;  // of an interval, where nothing asks for fine steps
  static constexpr double kRampAfterGap = 1.0;  // [s], the end of a gap in which the source comes back
  static constexpr double kMostCurrent = 1e4;   // [A], beyond anything a source gives
  static constexpr unsigned kFadingLooked = 1024;  // intervals; too few to fade from kFaded to what is stuck

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

  void findHooks() {
    for (std::size_t k = 0; k < model_->effects().size(); ++k)
      if (model_->effects()[k] == kLearnedEffect) force_parameter_ = static_cast<int>(model_->firstParameter(k));
    for (const Member& member : members_) {
      const EffectHooks& hooks = member.effect->hooks;
      if (hooks.activity) activity_state_ = member.state;
      if (hooks.is_ladder) ladder_state_ = member.state;
      if (hooks.steps_finely) steps_finely_ = true;
      if (hooks.limits_reaction) limits_reaction_ = true;
      if (hooks.longest_piece > 0.0 && (longest_piece_ == 0.0 || hooks.longest_piece < longest_piece_))
        longest_piece_ = hooks.longest_piece;
      if (hooks.adapt) adapts_ = true;
    }
  }

  /// The double layer of the composition in arithmetic T.
  template <typename T>
  DoubleLayer<T> layerOf() const {
    std::vector<BoundEffect> side;
    BoundEffect activity{nullptr, 0};
    for (const Member& member : members_) {
      const BoundEffect bound{member.effect, member.parameter};
      if (member.effect->hooks.side_current) side.push_back(bound);
      if (member.effect->hooks.activity) activity = bound;
    }
    return DoubleLayer<T>(side, activity.effect ? &activity : nullptr, ladder_state_ >= 0, limits_reaction_);
  }

  /// Whether what an effect owns can have a say in the double layer's movement.
  static bool reachesLayer(const EffectHooks& hooks) {
    return hooks.sense || hooks.adapt || hooks.side_current || hooks.activity || hooks.is_ladder ||
           hooks.steps_finely;
  }

  /// Lanes that move something which can reach the double layer.
  std::vector<int> lanesOfLayer(const Eigen::Ref<const Eigen::MatrixXd>& seeds) const {
    std::vector<Eigen::Index> rows = {kRowC2, kRowBeta, model_->parameterCount()};
    // An effect that adapts the base model may read all of it.
    if (adapts_ || steps_finely_)
      rows.insert(rows.end(), {kRowRDischarge, kRowRCharge, kRowUDc});
    for (const Member& member : members_) {
      if (!reachesLayer(member.effect->hooks)) continue;
      // A side reaction goes with the electrode's voltage against its own equilibrium, not with u_c2 alone.
      if (member.effect->hooks.side_current) rows.push_back(kRowUDc);
      const EffectInfo& info = member.effect->info;
      for (std::size_t j = 0; j < info.parameters.size(); ++j)
        rows.push_back(member.parameter + static_cast<Eigen::Index>(j));
      for (std::size_t j = 0; j < info.states.size(); ++j)
        rows.push_back(model_->parameterCount() + member.state + static_cast<Eigen::Index>(j));
    }
    std::vector<int> lanes;
    for (Eigen::Index k = 0; k < seeds.cols(); ++k)
      if ((seeds.col(k)(rows).array() != 0.0).any()) lanes.push_back(static_cast<int>(k));
    return lanes;
  }

  std::unique_ptr<LayerOf<S>> layerFor(const std::vector<int>& lanes) const {
    std::unique_ptr<LayerOf<S>> layer = narrowFor<8>(lanes);
    if (!layer) layer = narrowFor<16>(lanes);
    if (!layer) layer = narrowFor<24>(lanes);
    if (!layer) layer = std::make_unique<WideLayer<S>>(layerOf<S>());
    return layer;
  }
  /// @return nothing unless N lanes suffice and are fewer than those of S.
  template <int N>
  std::unique_ptr<LayerOf<S>> narrowFor(const std::vector<int>& lanes) const {
    if constexpr (N < kWidth) {
      if (lanes.size() <= static_cast<std::size_t>(N))
        return std::make_unique<NarrowLayer<S, N>>(
            layerOf<Dual<N>>(), typename NarrowLayer<S, N>::Shape{lanes, p_.size(), ladder_state_ >= 0, adapts_});
    }
    return nullptr;
  }

  /// From here on every lane may reach the layer: a current that follows from a voltage depends on all of them.
  void widen() {
    if (is_wide_) return;
    is_wide_ = true;
    std::unique_ptr<LayerOf<S>> wide = localFor<8>();
    if (!wide) wide = localFor<16>();
    if (!wide) wide = std::make_unique<WideLayer<S>>(layerOf<S>());
    wide->suggestStep(layer_->suggestedStep());
    layer_ = std::move(wide);
  }
  /// @return nothing unless the layer has implicit steps, into which at most N quantities flow, fewer than S has lanes.
  template <int N>
  std::unique_ptr<LayerOf<S>> localFor() const {
    if constexpr (N < kWidth) {
      typename LocalLayer<S, N>::Shape shape{{}, p_.size(), activity_state_ >= 0, adapts_};
      for (const Member& member : members_)
        if (member.effect->hooks.side_current || member.effect->hooks.activity)
          for (std::size_t j = 0; j < member.effect->info.parameters.size(); ++j)
            shape.parameters.push_back(member.parameter + static_cast<int>(j));
      const bool is_implicit = !shape.parameters.empty() && !limits_reaction_ && ladder_state_ < 0;
      if (is_implicit && shape.inputs() <= N) return std::make_unique<LocalLayer<S, N>>(layerOf<Dual<N>>(), shape);
    }
    return nullptr;
  }

  /// A learnt force, where there is one, over an interval in which u_c2 went from `before` to `end`.
  void moveForce(const S& before, const S& end, double duration, const Seen& seen, const Present<S>& present) {
    if (!force_) return;
    const S mean = S(0.5 * (before + end));
    force_->advance({{duration, seen.end, seen.held, seen.gap, end, present.time}, before, conductanceOf(mean, present), present.c2},
                    force_parameter_ >= 0 ? &p_[static_cast<std::size_t>(force_parameter_)] : nullptr);
  }

  /// A learnt force after a step under a current [V]; moves nothing.
  S forceAfter(const S& i, double duration, const S& u, const Present<S>& present) {
    kept_force_ = force_->state();
    moveForce(x_[0], u, duration, {i, i, false}, present);
    std::swap(force_->state(), kept_force_);
    return force_->voltage();
  }
  /// Its slope to u_c2 at the step's end [1].
  double forceSlope(double i, double duration, double u, const Present<S>& present) {
    return derivativesOf(forceAfter(S(i), duration, S(u, Eigen::Matrix<double, 1, 1>::Ones()), present))[0];
  }

  /// d i_r2 / d u_c2 [1/Ohm].
  S conductanceOf(const S& u, const Present<S>& present) const {
    using std::exp;
    constexpr double kMostExponent = 300.0;
    const auto bounded = [](const S& x) { return std::abs(valueOf(x)) > kMostExponent ? S(std::copysign(kMostExponent, valueOf(x))) : x; };
    const S up = S(present.alpha * present.beta), down = S(present.beta - up);
    S charging = S(present.i0 * present.reactivity * exp(bounded(S(up * u))));
    if (activity_state_ >= 0) charging = S(charging * exp(x_[static_cast<std::size_t>(activity_state_)]));
    const S discharging = S(present.i0 * exp(bounded(S(-(down * u)))));
    const S free = S(up * charging + down * discharging), limit = S(1.0 + charging * present.inverse_supply);
    return S((free - (charging - discharging) * (up * charging * present.inverse_supply) / limit) / limit);
  }

  static const EffectKernel<S>& kernel(const Member& member) { return kernelOf(*member.effect, S()); }
  S* stateOf(const Member& member) {
    return member.state < static_cast<int>(x_.size()) ? &x_[member.state] : nullptr;
  }

  Present<S> bareModel() const {
    return {p_[kRowRDischarge], p_[kRowRCharge], p_[kRowC2], p_[kRowBeta], p_[kRowUDc],
            S(BaseParameters{}.i0), S(BaseParameters{}.alpha), S(1.0), S(0.0), S(0.0), S(1.0), S(0.0), 0.0};
  }

  /// The base model as effects leave it; until the next call.
  const Present<S>& presentAt(double time) {
    if (adapts_) present_ = bareModel();
    present_.time = time - reference_time_;
    for (const Member& member : members_)
      if (member.effect->hooks.adapt)
        kernel(member).adapt(&p_[member.parameter], stateOf(member), present_);
    return present_;
  }

  /**
   * @brief How far to go at once with `done` of an interval passed.
   *
   * Where effects act back on others an interval is cut into equal pieces of at most longest_piece_. After the first 20 s of a
   * longer one pieces grow with the time passed: what began with it settles down to slower and slower change.
   */
  double pieceOf(double duration, double done) const {
    if (longest_piece_ == 0.0) return duration;
    const double pieces = std::ceil(duration / longest_piece_);
    const double even = duration / (steps_finely_ ? pieces : std::min(pieces, kMostPieces));
    return std::min(std::max(even, kGrowing * done), duration - done);
  }

  void passPiece(const S& held, double duration, double end_time) {
    const double middle = end_time - 0.5 * duration;
    if (steps_finely_) advanceMembers(held, 0.5 * duration, x_[0], presentAt(middle), true);
    const Present<S>& present = presentAt(middle);
    const S before = x_[0];
    layer_->advance(p_.data(), present, held, duration, x_[0],
                   activity_state_ >= 0 ? &x_[activity_state_] : nullptr,
                   ladder_state_ >= 0 ? &x_[ladder_state_] : nullptr);
    const S mean = S(0.5 * (before + x_[0]));
    if (limits_reaction_) reaction_ = reactionOf(held, S(x_[0] - before), mean, duration);
    advanceMembers(held, duration, mean, present, false);
    if (steps_finely_) advanceMembers(held, 0.5 * duration, x_[0], present, true);
  }

  /// Mean of what reacted over an interval: what was neither stored nor went past the reaction.
  S reactionOf(const S& held, const S& moved, const S& mean, double duration) const {
    S reacted = duration > 0.0 && ladder_state_ < 0 ? S(held - present_.c2 * moved * (1.0 / duration)) : held;
    for (const Member& member : members_)
      if (member.effect->hooks.side_current)
        reacted = S(reacted - kernel(member).sideCurrent(&p_[member.parameter], mean, present_));
    return reacted;
  }

  void advanceMembers(const S& held, double duration, const S& u_c2, const Present<S>& present,
                      bool fine) {
    const Passage<S> passage{held, duration, u_c2, reaction_, present};
    for (const Member& member : members_)
      if (member.effect->hooks.advance && member.effect->hooks.steps_finely == fine)
        kernel(member).advance(&p_[member.parameter], stateOf(member), passage);
  }

  /// The same battery in the arithmetic of the solver for the current, as it stands.
  EngineOf<Slope>& probe() {
    if (!probe_) {
      ModelPoint here;
      here.reference_time = reference_time_;
      here.parameters.resize(static_cast<Eigen::Index>(p_.size()));
      for (std::size_t j = 0; j < p_.size(); ++j)
        here.parameters[static_cast<Eigen::Index>(j)] = valueOf(p_[j]);
      here.state = state();
      here.force_memory = forceMemory();
      probe_ = std::make_unique<EngineOf<Slope>>(*model_, here, Eigen::MatrixXd());
    }
    EngineOf<Slope>& same = *probe_;
    same.time_ = time_;
    for (std::size_t j = 0; j < x_.size(); ++j) same.x_[j] = Slope(valueOf(x_[j]));
    if (force_)
      for (std::size_t j = 0; j < force_->state().size(); ++j) same.force_->state()[j] = Slope(valueOf(force_->state()[j]));
    same.layer_->suggestStep(layer_->suggestedStep());
    return same;
  }

  /// @return how far a held current ends above a voltage [V]; leaves the probe there.
  double excessOf(double i, double voltage, double duration) {
    const Slope current(i, Eigen::Matrix<double, 1, 1>::Ones());
    EngineOf<Slope>& trial = probe();
    trail_.begin();
    trial.layer_->useTrail(&trail_);
    trial.pass(current, current, duration, 0.0, time_ + duration);
    trial.layer_->useTrail(nullptr);
    return valueOf(trial.terminal_) - voltage;
  }

  /// Holds the current that ends at the voltage. Trials go in the probe; the last step of the search is taken in arithmetic S.
  double advanceBySearch(const S& voltage, double duration, double most_current) {
    const double wanted = valueOf(voltage), before = last_current_;
    const double move = valueOf(terminal_) != 0.0 ? wanted - valueOf(terminal_) : 0.0;
    SourceSearch search(firstCurrent(move), most_current);
    search.expectBend(source_bend_);
    trail_.clear();
    bool done = false;
    for (int k = 0; k < SourceSearch::kMostTrials && !done; ++k) {
      const double tried = search.current(), excess = excessOf(tried, wanted, duration);
      if (search.isLimited(excess)) {
        holdAtMost(tried, duration);
        break;
      }
      search.take(excess, probe_->terminal_.derivatives()[0]);
      const bool is_last = k + 1 == SourceSearch::kMostTrials || !std::isfinite(excess);
      done = is_last ? adopt(voltage, duration, tried, search) : land(voltage, duration, tried, search);
    }
    source_bend_ = search.bend();
    last_current_ = valueOf(source_current_);
    source_trend_ = before != 0.0 ? last_current_ - before : 0.0;
    source_move_ = move;
    source_resistance_ = probe_->terminal_.derivatives()[0];
    return last_current_;
  }

  /// What flows next: the trend goes on, but for what the voltage moves otherwise than it did.
  double firstCurrent(double move) const {
    return last_current_ + source_trend_ + (source_resistance_ > 0.0 ? (move - source_move_) / source_resistance_ : 0.0);
  }

  /// Ends a search where it is about to. @return false, nothing moved, when it has to go on.
  bool land(const S& voltage, double duration, double tried, SourceSearch& search) {
    if constexpr (std::is_same_v<S, double>) return search.isThere() && adopt(voltage, duration, tried, search);
    if (lanes_ == kWidth) return search.isThere(kLastStepByProbe) && adopt(voltage, duration, tried, search);
    return search.isNear() && passAlong(voltage, duration, search);
  }

  /// Ends where the probe ended, and what its slopes make of the last step.
  bool adopt(const S& voltage, double duration, double tried, const SourceSearch& search) {
    if constexpr (std::is_same_v<S, double>) {
      takeProbe(search.current() - tried);
      source_current_ = search.current();
    } else {
      source_current_ = S(search.current());
      passAsTried(source_current_, duration);
      letCurrentFollow(voltage);
    }
    return true;
  }
  void holdAtMost(double most_current, double duration) {
    source_current_ = S(most_current);
    if constexpr (std::is_same_v<S, double>)
      takeProbe(0.0);
    else
      passAsTried(source_current_, duration);
  }

  /// One pass of the hold in arithmetic S, from where the trials know its implicit steps to end.
  void passAsTried(const S& current, double duration) {
    trail_.begin();
    layer_->useTrail(&trail_);
    pass(current, current, duration, 0.0, time_ + duration);
    layer_->useTrail(nullptr);
  }

  /// The probe's end with `more` current [A], to first order.
  void takeProbe(double more) {
    const auto there = [more](const Slope& x) { return x.value() + x.derivatives()[0] * more; };
    const EngineOf<Slope>& from = *probe_;
    for (std::size_t j = 0; j < x_.size(); ++j) x_[j] = S(there(from.x_[j]));
    terminal_ = S(there(from.terminal_));
    voltage_ = S(there(from.voltage_));
    reaction_ = S(there(from.reaction_));
    if (force_) {
      for (std::size_t j = 0; j < force_->state().size(); ++j) force_->state()[j] = S(there(from.force_->state()[j]));
      force_->setBeyond(from.force_->beyond());
    }
    layer_->suggestStep(from.layer_->suggestedStep());
    intervals_ = from.intervals_;
    time_ = from.time_;
  }

  /**
   * @brief The hold in arithmetic S with the current as one lane more: Newton's last step, and the implicit function's derivatives.
   *
   * @return false, nothing moved, when that step is longer than a last one may be; `search` goes on from there.
   */
  bool passAlong(const S& voltage, double duration, SourceSearch& search) {
    if constexpr (std::is_same_v<S, double>) {
      return false;
    } else {
      const double time = time_, suggested = layer_->suggestedStep();
      const S reaction = reaction_, terminal = terminal_, shown = voltage_;
      kept_ = x_;
      if (force_) kept_force_ = force_->state();
      S held(search.current());
      held.derivatives()[lanes_] = 1.0;
      passAsTried(held, duration);
      search.take(valueOf(terminal_) - valueOf(voltage), terminal_.derivatives()[lanes_]);
      if (search.isThere()) {
        foldCurrent(held, search.current(), voltage);
        return true;
      }
      std::swap(x_, kept_);
      if (force_) std::swap(force_->state(), kept_force_);
      reaction_ = reaction;
      terminal_ = terminal;
      voltage_ = shown;
      time_ = time;
      layer_->suggestStep(suggested);
      return false;
    }
  }

  /// Takes the current's lane up into the others: it is what keeps the terminal at the voltage. @param end [A], of the search.
  void foldCurrent(const S& held, double end, const S& voltage) {
    const Eigen::Index own = lanes_;
    S follow = S((voltage - terminal_) * (1.0 / terminal_.derivatives()[own]));
    follow.value() = end - valueOf(held);
    follow.derivatives()[own] = 0.0;
    const auto fold = [&](S& x) {
      const double slope = x.derivatives()[own];
      x.derivatives()[own] = 0.0;
      x.value() += slope * follow.value();
      x.derivatives() += slope * follow.derivatives();
    };
    source_current_ = held;
    fold(source_current_);
    for (S& x : x_) fold(x);
    if (force_)
      for (S& x : force_->state()) fold(x);
    fold(terminal_);
    fold(voltage_);
    fold(reaction_);
  }

  static constexpr int kWidth = Width<S>::value;
  static constexpr double kLastStepByProbe = 1e-5;  // [A], where derivatives are the last trial's

  /// Lets the current that was solved for follow the lanes so that the terminal voltage stays: the implicit function's
  /// derivative, by the slopes that the probe has to the current.
  void letCurrentFollow(const S& voltage) {
    const EngineOf<Slope>& slopes = *probe_;
    const auto slope = [](const Slope& x) { return x.derivatives()[0]; };
    const S follow =
        S((valueOf(terminal_) - terminal_ + voltage - valueOf(voltage)) / slope(slopes.terminal_));
    source_current_ = S(source_current_ + follow);
    for (std::size_t j = 0; j < x_.size(); ++j) x_[j] = S(x_[j] + slope(slopes.x_[j]) * follow);
    if (force_)
      for (std::size_t j = 0; j < force_->state().size(); ++j)
        force_->state()[j] = S(force_->state()[j] + slope(slopes.force_->state()[j]) * follow);
    terminal_ = S(terminal_ + slope(slopes.terminal_) * follow);
    voltage_ = S(voltage_ + slope(slopes.voltage_) * follow);
  }

  Eigen::Index lanes_;
  double time_, reference_time_;
  int activity_state_ = -1, ladder_state_ = -1;
  int force_parameter_ = -1;  // first factor
  bool steps_finely_ = false, adapts_ = false, is_wide_ = false, limits_reaction_ = false;
  double longest_piece_ = 0.0;  // [s], see EffectHooks
  unsigned intervals_ = 0;  // since fading numbers were dropped
  std::shared_ptr<const BatteryModel> model_;
  std::vector<Member> members_;
  std::unique_ptr<LayerOf<S>> layer_;
  std::unique_ptr<ForceRun<S>> force_;
  std::vector<S> kept_force_;  // work space of othersVoltage()
  std::vector<S> p_, x_;
  Present<S> present_;
  S voltage_ = S(0.0), terminal_ = S(0.0), source_current_ = S(0.0), current_error_ = S(0.0);
  S reaction_ = S(0.0);  // of the last piece [A], where an effect asks for it
  S kept_reaction_ = S(0.0);
  std::vector<S> kept_;  // work space of othersVoltage()
  // Of the last hold behind a source, for the next one's first guess: [A] that the current and [V] that the voltage moved, [Ohm],
  // [1/A] as SourceSearch::bend(); and the last current of all [A].
  double source_trend_ = 0.0, source_move_ = 0.0, source_resistance_ = 0.0, source_bend_ = 0.2, last_current_ = 0.0;
  StepTrail trail_;  // work space of a search
  std::unique_ptr<EngineOf<Slope>> probe_;
};

}  // namespace battery_sof
