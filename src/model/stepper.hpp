#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "composed_effects.hpp"
#include "discrepancy_run.hpp"
#include "double_layer.hpp"
#include "model/simulation.hpp"

namespace battery_sof {

/// What is worth keeping between two calls and says nothing: a copy begins with a fresh one.
template <typename T>
class WorkSpace {
 public:
  WorkSpace() = default;
  WorkSpace(const WorkSpace&) : own_() {}
  WorkSpace(WorkSpace&&) noexcept = default;
  WorkSpace& operator=(WorkSpace other) noexcept {
    own_ = std::move(other.own_);
    return *this;
  }
  ~WorkSpace() = default;
  T& operator*() { return own_; }
  T* operator->() { return &own_; }

 private:
  T own_;
};

/// For how long a measured current has been the same but for small changes.
struct SteadyCurrent {
  double current = 0.0;   ///< [A], where it began
  double duration = 0.0;  ///< [s]

  /// Another interval begins. @param held [A], its current.
  void begin(double held) {
    constexpr double kSmall = 0.05, kNoise = 0.02;  // of the current; [A]
    if (std::abs(held - current) <= kNoise + kSmall * std::abs(current)) return;
    *this = {held, 0.0};
  }
};

/// Where a battery stands: all that moves, in arithmetic S. What never moves is the stepper's.
template <typename S>
struct SimulationState {
  double time = 0.0;  ///< [s]
  std::vector<S> x;   ///< states, in the composition's order; first u_c2 [V]
  /// memory of a discrepancy model, as firstRegressorMemory()
  std::vector<S> discrepancy;
  /// [V], of the battery and as its channel shows it; 0 before the first interval
  S terminal = S(0.0), voltage = S(0.0);
  double last_current = 0.0;  ///< [A], at the end of the last interval
  LayerPace pace;             ///< of the double layer's steps
  SteadyCurrent steady;       ///< the measured current, while it is the input
  unsigned intervals = 0;     ///< since fading numbers were dropped
};

/// Changes every number that carries tangents, each together with its counterpart in another state
/// of the same battery.
template <typename S, typename T, typename Change>
void changeNumbersBeside(SimulationState<S>& to, const SimulationState<T>& from,
                         const Change& change) {
  for (std::size_t j = 0; j < to.x.size(); ++j) change(to.x[j], from.x[j]);
  for (std::size_t j = 0; j < to.discrepancy.size(); ++j)
    change(to.discrepancy[j], from.discrepancy[j]);
  change(to.terminal, from.terminal);
  change(to.voltage, from.voltage);
}
/// Takes the other's numbers, each as `number` makes it one of arithmetic S.
template <typename S, typename T, typename Number>
void standAs(SimulationState<S>& to, const SimulationState<T>& from, const Number& number) {
  changeNumbersBeside(to, from, [&](S& x, const T& y) { x = S(number(y)); });
  to.time = from.time;
  to.last_current = from.last_current;
  to.pace = from.pace;
  to.steady = from.steady;
  to.intervals = from.intervals;
}

/// The current over an interval as a discrepancy model sees it: the measured one.
template <typename S>
struct SeenCurrent {
  S held, end;
  bool gap;
};

/**
 * @brief A battery that passes through intervals under a held current, in arithmetic S. See
 * Simulation for the method.
 *
 * Copied with all it is.
 */
template <typename S>
class Stepper {
 public:
  Stepper(std::shared_ptr<const BoundComposition> bound, const ModelPoint& start,
          const Eigen::Ref<const Eigen::MatrixXd>& seeds)
      : tangents_(seeds.cols()),
        effects_(bound, start.parameters, start.reference_time, seeds),
        layer_(*bound) {
    now.time = start.time;
    for (Eigen::Index j = 0; j < start.state.size(); ++j)
      now.x.push_back(seeded(start.state[j], seeds, start.parameters.size() + j, S()));
    if (!bound->model.discrepancy()) return;
    discrepancy_.emplace(bound->model.discrepancy());
    now.discrepancy = firstRegressorMemory<S>(*bound->model.discrepancy(), start.regressor_memory);
  }

  SimulationState<S> now;

  Eigen::Index tangents() const { return tangents_; }
  const ComposedEffects<S>& effects() const { return effects_; }
  const Present<S>& presentAt(double time) { return effects_.presentAt(time, now.x); }
  S* activity() { return stateAt(effects_.bound().activity_state); }
  S* ladder() { return stateAt(effects_.bound().ladder_state); }
  const std::optional<DiscrepancyRun<S>>& discrepancy() const { return discrepancy_; }
  void setBeyondIdentified(double beyond) {
    if (discrepancy_) discrepancy_->setBeyond(beyond);
  }

  /// The battery as it stands, in values.
  ModelPoint point() const {
    return {valuesOf(effects_.parameters()), valuesOf(now.x), now.time, effects_.referenceTime(),
            regressorMemory()};
  }

  std::vector<double> regressorMemory() const {
    std::vector<double> memory;
    for (const S& x : now.discrepancy) memory.push_back(valueOf(x));
    return memory;
  }

  DoubleLayer<S>& layer() { return layer_; }

  /// One interval under a held current of the battery itself. @param slope [A/s], of the measured
  /// current.
  void pass(const S& held, const S& end, double duration, double slope, double end_time) {
    pass(held, end, duration, slope, end_time, {held, end, false});
  }
  /// @param ramp_pieces in which a current that is linear in time is passed:
  /// InputStep::rampPieces().
  void pass(const S& held, const S& end, double duration, double slope, double end_time,
            const SeenCurrent<S>& seen, int ramp_pieces = 1) {
    const S before = discrepancy_ ? now.x[0] : S(0.0);
    now.last_current = valueOf(end);
    const S rise = ramp_pieces > 1 ? S((end - held) * (2.0 / duration)) : S(0.0);
    for (double done = 0.0; done < duration;) {
      const double piece = std::min(pieceOf(duration, done), duration / ramp_pieces),
                   middle = done + 0.5 * piece;
      done = done + piece < duration * (1.0 - 1e-12) ? done + piece : duration;
      passPiece(ramp_pieces > 1 ? S(held + rise * (middle - 0.5 * duration)) : held, piece,
                end_time - duration + done);
    }
    if (++now.intervals == kFadingLooked) {
      now.intervals = 0;
      for (S& x : now.x) dropFaded(x);
    }
    now.time = end_time;
    const Present<S>& present = presentAt(end_time);
    moveDiscrepancy(before, now.x[0], duration, seen, present, now.discrepancy);
    show({end, slope, duration, present});
  }

  /// An interval at whose end u_c2 is known: effects and discrepancy remain. @param mean of
  /// u_c2.  @param present in its middle.
  void passKnown(const S& current, const S& u_c2, const S& mean, double duration,
                 const Present<S>& present) {
    const double end_time = now.time + duration;
    const S start = now.x[0];
    now.last_current = valueOf(current);
    now.x[0] = u_c2;
    const Passage<S> passage{current, duration, mean,
                             reactionOf(current, S(u_c2 - start), mean, duration), present};
    for (const bool finely : {false, true}) effects_.advance(passage, finely, now.x);
    now.time = end_time;
    moveDiscrepancy(start, now.x[0], duration, {current, current, false}, present, now.discrepancy);
    show({current, 0.0, duration, presentAt(end_time)});
  }

  /// Everything in the terminal voltage but u_c2 after a step under a current [V]; moves nothing.
  S othersVoltage(const S& i, double duration, const S& u, const Present<S>& present) {
    std::vector<S>& x = work_->x = now.x;
    effects_.advance({i, duration, u, i, present}, false, x);
    const Instant<S> instant{i, 0.0, duration, present};
    S voltage = S(present.u_dc + ohmic(present, i) * i);
    effects_.addVoltages(instant, x, voltage);
    return discrepancy_ ? S(voltage + discrepancyAfter(i, duration, u, present)) : voltage;
  }

  /// Slope of a discrepancy model after such a step to its end's u_c2 [1]; in arithmetic Slope.
  double discrepancySlope(double i, double duration, double u, const Present<S>& present) {
    return discrepancyAfter(S(i), duration, S::unknown(u), present).slope();
  }

  /// Charge that nobody saw flow [As]: it goes into the effects' balances and moves no voltage.
  void discharge(double charge) {
    constexpr double kAtOnce = 1e-9;  // [s]
    const S reaction(-charge / kAtOnce), none(0.0);
    const Present<S>& present = presentAt(now.time);
    effects_.advance({none, kAtOnce, now.x[0], reaction, present}, false, now.x);
  }

 private:
  static constexpr double kGrowing = 0.005;  // of the time for which the current is the same
  // of an interval, where nothing requires fine steps
  static constexpr double kMaxPieces = 8.0;
  // intervals; too few to fade from kFaded to what is stuck
  static constexpr unsigned kFadingLooked = 1024;

  static const S& ohmic(const Present<S>& present, const S& current) {
    return valueOf(current) < 0.0 ? present.r_discharge : present.r_charge;
  }
  S* stateAt(int j) { return j >= 0 ? &now.x[j] : nullptr; }

  /// Terminal voltage at an instant, and what the channel makes of it.
  void show(const Instant<S>& instant) {
    now.terminal = S(instant.present.u_dc + now.x[0] +
                     ohmic(instant.present, instant.current) * instant.current);
    effects_.addVoltages(instant, now.x, now.terminal);
    if (discrepancy_) now.terminal = S(now.terminal + discrepancy_->voltage());
    now.voltage = now.terminal;
    effects_.show(instant, now.x, now.voltage);
  }

  /**
   * @brief How far to go at once with `done` of an interval passed.
   *
   * Where effects act back on others an interval is cut into equal pieces of at most longest_piece.
   * Pieces grow to kGrowing of the time for which the current has been the same: what began with it
   * settles down to slower and slower change.
   */
  double pieceOf(double duration, double done) const {
    const BoundComposition& bound = effects_.bound();
    if (bound.longest_piece == 0.0) return duration;
    const double pieces = std::ceil(duration / bound.longest_piece);
    const double even = duration / (bound.steps_finely ? pieces : std::min(pieces, kMaxPieces));
    return std::min(std::max(even, kGrowing * (now.steady.duration + done)), duration - done);
  }

  void passPiece(const S& held, double duration, double end_time) {
    const BoundComposition& bound = effects_.bound();
    const double middle = end_time - 0.5 * duration;
    if (bound.steps_finely) advanceFinely(held, 0.5 * duration, presentAt(middle));
    const Present<S>& present = presentAt(middle);
    const S before = now.x[0];
    layer_.advance(effects_.parameters().data(), present, held, duration, now.pace, now.x[0],
                   activity(), ladder());
    const S mean = S(0.5 * (before + now.x[0]));
    if (bound.limits_reaction)
      effects_.advance(
          {held, duration, mean, reactionOf(held, S(now.x[0] - before), mean, duration), present},
          false, now.x);
    else
      effects_.advance({held, duration, mean, held, present}, false, now.x);
    if (bound.steps_finely) advanceFinely(held, 0.5 * duration, present);
  }
  /// No effect that steps finely requires what reacted.
  void advanceFinely(const S& held, double duration, const Present<S>& present) {
    effects_.advance({held, duration, now.x[0], held, present}, true, now.x);
  }

  /// Mean of what reacted over an interval: what was neither stored nor went past the reaction [A].
  S reactionOf(const S& held, const S& moved, const S& mean, double duration) const {
    const bool is_stored = duration > 0.0 && effects_.bound().ladder_state < 0;
    return effects_.lessSideCurrents(
        is_stored ? S(held - effects_.present().c2 * moved * (1.0 / duration)) : held, mean);
  }

  /// A discrepancy model, where there is one, over an interval in which u_c2 went from `before` to
  /// `end`. @param memory updated.
  void moveDiscrepancy(const S& before, const S& end, double duration, const SeenCurrent<S>& seen,
                       const Present<S>& present, std::vector<S>& memory) {
    if (!discrepancy_) return;
    const S mean = S(0.5 * (before + end));
    const int first = effects_.bound().discrepancy_parameter;
    discrepancy_->advance({{duration, seen.end, seen.held, seen.gap, end, present.time},
                           before,
                           conductanceOf(mean, present),
                           present.c2},
                          first >= 0 ? effects_.parameters().data() + first : nullptr, memory);
  }
  /// A discrepancy model after a step under a current [V]; moves nothing.
  const S& discrepancyAfter(const S& i, double duration, const S& u, const Present<S>& present) {
    work_->discrepancy = now.discrepancy;
    moveDiscrepancy(now.x[0], u, duration, {i, i, false}, present, work_->discrepancy);
    return discrepancy_->voltage();
  }

  /// d i_r2 / d u_c2 [1/Ohm].
  S conductanceOf(const S& u, const Present<S>& present) const {
    using std::exp;
    const int activity = effects_.bound().activity_state;
    const S up = S(present.alpha * present.beta), down = S(present.beta - up);
    S charging = S(present.i0 * present.reactivity * exp(bounded(S(up * u))));
    if (activity >= 0) charging = S(charging * exp(now.x[activity]));
    const S discharging = S(present.i0 * exp(bounded(S(-(down * u)))));
    const S free = S(up * charging + down * discharging),
            limit = S(1.0 + charging * present.inverse_supply);
    return S((free - (charging - discharging) * (up * charging * present.inverse_supply) / limit) /
             limit);
  }

  struct Work {
    std::vector<S> x, discrepancy;
  };

  Eigen::Index tangents_;
  ComposedEffects<S> effects_;
  DoubleLayer<S> layer_;
  std::optional<DiscrepancyRun<S>> discrepancy_;
  WorkSpace<Work> work_;
};

}  // namespace battery_sof
