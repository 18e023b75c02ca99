#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "bound_composition.hpp"
#include "effects/effect_definition.hpp"
#include "layer_flow.hpp"
#include "layer_parts.hpp"
#include "util/constants.hpp"

namespace battery_sof {

/**
 * @brief A fractional capacitance as a capacitance and a ladder of relaxing ones (Foster form;
 * docs/physics.md#constant-phase-element).
 *
 *     C w_c^g d^(1-g) u / dt^(1-g)  =  C [ h du/dt + sum_k l_k (u - v_k) ],   dv_k/dt = w_k (u - v_k)
 *     h = sinc(pi g) (w_c / w_hi)^g,   l_k = g sinc(pi g) w_c^g w_k^(1-g) ln(ratio)
 *
 * on a grid w_k of constant ratio that ends half a step below w_hi; g = 0 gives h = 1 and l_k = 0
 * exactly.
 */
template <typename S>
struct Ladder {
  // w_c [rad/s], keeps the meaning of C: docs/physics.md#cpe2
  static constexpr double kCorner = 0.3;
  static constexpr double kSlowest = 1e-5, kFastest = 1e3;  // [rad/s]

  S head;                            // h [1]
  std::array<S, kLadderRungs> rung;  // l_k [rad/s]

  static double rate(int k) {
    static const std::array<double, kLadderRungs> rates = [] {
      std::array<double, kLadderRungs> all;
      for (int j = 0; j < kLadderRungs; ++j)
        all[j] = kSlowest * std::pow(kFastest / kSlowest, j / (kLadderRungs - 1.0));
      return all;
    }();
    return rates[k];
  }
  static double logRatio() { return std::log(kFastest / kSlowest) / (kLadderRungs - 1); }

  explicit Ladder(const S& dispersion) {
    using std::exp;
    using std::sin;
    const S angle = S(kPi * dispersion);
    const S sinc = valueOf(angle) < 1e-4 ? S(1.0 - angle * angle / 6.0) : S(sin(angle) / angle);
    const double fastest_edge = std::log(kFastest) + 0.5 * logRatio();
    head = S(sinc * exp(S(dispersion * (std::log(kCorner) - fastest_edge))));
    for (int k = 0; k < kLadderRungs; ++k)
      rung[k] = S(dispersion * sinc * exp(S(dispersion * std::log(kCorner / rate(k)))) *
                  (rate(k) * logRatio()));
  }
};

/// Where one implicit Euler step at a source's voltage ends.
struct SourceStep {
  double u = 0.0;        ///< [V], of the double layer
  double current = 0.0;  ///< [A]
  double slope = 0.0;    ///< of the balance of currents at u, the current held [A/V]
};

/**
 * @brief The double layer with what is bound to it, in arithmetic S: one step under a held current.
 *
 *     C_2 du/dt = i - side currents(u) - i_r2(u)                                       (and dp/dt of the effect that has p)
 *     i_r2 = I_0 [ p g exp(a b u) - exp((a - 1) b u) ] / (1 + I_0 p g exp(a b u) / L)
 *
 * See Simulation for the method.
 */
template <typename S>
class DoubleLayer {
 public:
  explicit DoubleLayer(const BoundComposition& bound)
      : has_activity_(bound.activity_state >= 0),
        has_ladder_(bound.ladder_state >= 0),
        is_limited_(bound.limits_reaction) {
    for (const BoundComposition::Member& member : bound.members) {
      if (member.effect->hooks.side_current) side_.push_back(member);
      if (member.effect->hooks.activity) activity_ = member;
    }
    const std::size_t size = 2 + (has_ladder_ ? kLadderRungs : 0);
    for (auto* buffer : {&before_, &whole_, &half_, &halves_}) buffer->assign(size, S(0.0));
  }

  /// @param p all parameters.  @param pace updated.
  /// @param u, log_activity, ladder states, updated; the last two may be nullptr.
  void advance(const S* p, const Present<S>& present, const S& current, double duration,
               LayerPace& pace, S& u, S* log_activity, S* ladder) {
    if (duration <= 0.0) return;
    if (isPlain(present)) {
      advancePlain(present, current, duration, u);
      return;
    }
    prepare(p, present);
    if (!has_activity_ && !has_ladder_) {
      LayerFlow<S>{side_,        p, present, charging_slope_, discharging_slope_, is_limited_,
                   is_symmetric_}
          .advance(current, duration, pace, u);
      return;
    }
    load(u, log_activity, ladder);
    double left = duration;
    double& step = pace.step;
    for (StepsTaken taken(pace); left > 0.0;) {
      const double h = taken.next(left, step),
                   tolerance =
                       scaledTolerance(kTolerance, valueOf(before_[0]), valueOf(charging_slope_));
      const double error = attempt(p, present, current, h);
      const bool accepted = taken.accept(h, error <= tolerance);
      const double wanted =
          h * std::clamp(0.9 * std::sqrt(tolerance / std::max(error, 1e-12)), 0.2, 4.0);
      if (accepted) {
        const double begin = valueOf(before_[0]);
        extrapolate();
        rate_ = (valueOf(before_[0]) - begin) / h;
        left -= h;
        // A step cut by the interval's end says nothing against the longer one that was wanted.
        step = std::max(wanted, error <= tolerance && h < step ? step : wanted);
      } else {
        step = wanted;
      }
      step = std::max(step, kShortestStep);
    }
    store(u, log_activity, ladder);
  }

  /**
   * @brief One implicit Euler step of the double layer at a source.
   *
   *     C_2 (u - before) / h = i - i_r2(u) - side currents(u),   i = (emf - u) / resistance
   *
   * One equation in u that rises with it; no step is too long. beginStep(), stepAtSource() once or
   * more, imbalance(), endStep(): in this order.
   */
  void beginStep(const S* p, const Present<S>& present, double duration, const S& u,
                 const S* log_activity, const S* ladder) {
    prepare(p, present);
    load(u, log_activity, ladder);
    addStorage(present, duration, before_);
  }
  /// @param emf [V], what drives it.  @param resistance [Ohm].
  SourceStep stepAtSource(double emf, double resistance, double duration) {
    const Slope none(0.0);
    const Root root =
        solve(stageInValues(valueOf(storage_) + 1.0 / resistance,
                            valueOf(offset_) + emf / resistance, before_, none, duration),
              valueOf(before_[0]));
    activity_slope_ = root.activity_slope;
    return {root.u, (emf - root.u) / resistance, root.slope - 1.0 / resistance};
  }
  /// Imbalance of currents at u in arithmetic S, under `current` [A].
  S imbalance(const S* p, const Present<S>& present, const S& current, double duration, double u) {
    return balanceInS(p, stageInS(present, before_, current, duration), u, whole_[1]);
  }
  /// Moves activity and ladder to where u + moved ends. @param u where imbalance() was taken [V].
  void endStep(double duration, double u, const S& moved, S* log_activity, S* ladder) {
    using std::log;
    if (log_activity) *log_activity = log(S(whole_[1] + activity_slope_ * moved));
    if (!has_ladder_) return;
    moveLadder(duration, S(u + moved), before_, whole_);
    for (int k = 0; k < kLadderRungs; ++k) ladder[k] = whole_[2 + k];
  }

 private:
  static constexpr double kTolerance = 4e-5;  // [V] between one implicit step and its halves
  // [V], a first guess goes on at the last step's rate up to here
  static constexpr double kMaxMoved = 0.01;
  // [V], last step of Newton's method in doubles: beta / 2 of its square is left, of which the step
  // in arithmetic S leaves nothing, and the slope it shares with that step is good to 1e-5.
  static constexpr double kSettled = 1e-6;

  /// What an implicit Euler step solves, in the arithmetic of its solver.
  template <typename T>
  struct Stage {
    T storage, offset, activity_before;
    const T &charging_slope, &discharging_slope, &current;
    const Present<T>& present;
    double h;
  };

  bool isPlain(const Present<S>& present) const {
    return side_.empty() && !has_activity_ && !has_ladder_ && !is_limited_ && isHalf(present.alpha);
  }
  void load(const S& u, const S* log_activity, const S* ladder) {
    using std::exp;
    before_[0] = u;
    if (log_activity) before_[1] = exp(*log_activity);
    if (has_ladder_)
      for (int k = 0; k < kLadderRungs; ++k) before_[2 + k] = ladder[k];
  }
  void store(S& u, S* log_activity, S* ladder) const {
    using std::log;
    u = before_[0];
    if (log_activity) *log_activity = log(before_[1]);
    if (has_ladder_)
      for (int k = 0; k < kLadderRungs; ++k) ladder[k] = before_[2 + k];
  }

  /// From a step and its halves to second order; in the activity's logarithm, so that it stays
  /// positive.
  void extrapolate() {
    before_[0] = S(2.0 * halves_[0] - whole_[0]);
    if (has_activity_) before_[1] = S(halves_[1] * S(halves_[1] / whole_[1]));
    for (std::size_t k = 2; k < before_.size(); ++k) before_[k] = S(2.0 * halves_[k] - whole_[k]);
  }

  /// What stays the same over an interval.
  void prepare(const S* p, const Present<S>& present) {
    is_symmetric_ = isHalf(present.alpha);
    charging_slope_ = S(present.alpha * present.beta);
    discharging_slope_ = S((1.0 - present.alpha) * present.beta);
    charging_slope_value_ = Slope(valueOf(charging_slope_));
    discharging_slope_value_ = Slope(valueOf(discharging_slope_));
    if (has_ladder_ && (ladder_.empty() || dispersion_ != valueOf(present.dispersion))) {
      ladder_.assign(1, Ladder<S>(present.dispersion));
      dispersion_ = valueOf(present.dispersion);
    }
    present_slope_ = converted<Slope>(present, [](const S& x) { return Slope(valueOf(x)); });
    const auto take = [&](const BoundComposition::Member& bound) {
      std::vector<Slope> own;
      for (std::size_t j = 0; j < bound.effect->info.parameters.size(); ++j)
        own.push_back(Slope(valueOf(p[bound.parameter + static_cast<int>(j)])));
      return own;
    };
    // Parameters do not change within a simulation: converted once.
    if (!is_prepared_) {
      is_prepared_ = true;
      for (const BoundComposition::Member& bound : side_) side_slopes_.push_back(take(bound));
      if (has_activity_) activity_slopes_ = take(activity_);
    }
  }

  /// A step of h [s] from `from`, after addStorage(). @param current [A], has to stay.
  Stage<S> stageInS(const Present<S>& present, const std::vector<S>& from, const S& current,
                    double h) const {
    return {storage_, offset_, from[1], charging_slope_, discharging_slope_, current, present, h};
  }
  Stage<Slope> stageInValues(double storage, double offset, const std::vector<S>& from,
                             const Slope& current, double h) const {
    return {Slope(storage),           Slope(offset), Slope(valueOf(from[1])), charging_slope_value_,
            discharging_slope_value_, current,       present_slope_,          h};
  }

  /// Balance of currents at u; rises with u. @param activity after the step, where there is one.
  template <typename T, typename SideParameters, typename ActivityParameters>
  T balance(const Stage<T>& s, const T& u, const SideParameters& side_parameters,
            const ActivityParameters& activity_parameters, T& activity) const {
    using std::exp;
    const T rising = T(exp(bounded(T(s.charging_slope * u))));
    const T& i0 = s.present.i0;
    T charging = is_limited_ ? T(i0 * s.present.reactivity * rising) : T(i0 * rising);
    const T discharging =
        is_symmetric_ ? T(i0 / rising) : T(i0 * exp(bounded(T(-s.discharging_slope * u))));
    T sum = T(s.storage * u - s.offset - s.current);
    if (has_activity_) {
      const ReactionRates<T> rates{charging, discharging};
      activity = kernelOf(*activity_.effect, u)
                     .activity(activity_parameters(), s.activity_before, rates, s.present, s.h);
      charging = T(charging * activity);
    }
    const T reaction = T(charging - discharging);
    sum = is_limited_ ? T(sum + reaction / (1.0 + charging * s.present.inverse_supply))
                      : T(sum + reaction);
    for (std::size_t k = 0; k < side_.size(); ++k)
      sum = T(sum + kernelOf(*side_[k].effect, u).sideCurrent(side_parameters(k), u, s.present));
    return sum;
  }

  /// Implicit Euler step of everything from `from` to `to`. @param guess [V], near u at the step's
  /// end.
  void euler(const S* p, const Present<S>& present, const S& current, double h, double guess,
             const std::vector<S>& from, std::vector<S>& to) {
    addStorage(present, h, from);
    const Slope held(valueOf(current));
    const Root root =
        solve(stageInValues(valueOf(storage_), valueOf(offset_), from, held, h), guess);
    S activity(1.0);
    const S rest = balanceInS(p, stageInS(present, from, current, h), root.u, activity);
    // One Newton step in arithmetic S: what it adds to the value is below rounding, what it adds to
    // the derivatives is the implicit function's.
    const S moved = S(rest * (-1.0 / root.slope));
    to[0] = S(root.u + moved);
    if (has_activity_) to[1] = S(activity + root.activity_slope * moved);
    moveLadder(h, to[0], from, to);
  }

  /// A ladder after an implicit Euler step that ends at u.
  void moveLadder(double h, const S& u, const std::vector<S>& from, std::vector<S>& to) const {
    if (!has_ladder_) return;
    for (int k = 0; k < kLadderRungs; ++k) {
      const double share = h * Ladder<S>::rate(k);
      to[2 + k] = S((from[2 + k] + share * u) / (1.0 + share));
    }
  }

  /// What a step of h [s] from `from` stores: storage u - offset [A].
  void addStorage(const Present<S>& present, double h, const std::vector<S>& from) {
    storage_ = S(present.c2 / h);
    if (!has_ladder_) {
      offset_ = S(storage_ * from[0]);
      return;
    }
    const Ladder<S>& ladder = ladder_.front();
    const S head = S(storage_ * ladder.head);
    S rungs(0.0), pulled(0.0);
    for (int k = 0; k < kLadderRungs; ++k) {
      const S share = S(ladder.rung[k] / (1.0 + h * Ladder<S>::rate(k)));
      rungs = S(rungs + share);
      pulled = S(pulled + share * from[2 + k]);
    }
    storage_ = S(head + present.c2 * rungs);
    offset_ = S(head * from[0] + present.c2 * pulled);
  }

  S balanceInS(const S* p, const Stage<S>& stage, double u, S& activity) const {
    return balance<S>(
        stage, S(u), [&](std::size_t k) { return p + side_[k].parameter; },
        [&] { return p + activity_.parameter; }, activity);
  }

  struct Root {
    double u, slope;        // of the balance
    double activity_slope;  // d activity / du
  };
  /// Newton's method inside a bracket that grows from the start; the balance rises with u.
  Root solve(const Stage<Slope>& stage, double start) const {
    Slope activity(1.0);
    const auto at = [&](double u) {
      return balance<Slope>(
          stage, Slope::unknown(u), [&](std::size_t k) { return side_slopes_[k].data(); },
          [&] { return activity_slopes_.data(); }, activity);
    };
    const double steepest =
        std::max(valueOf(stage.charging_slope), valueOf(stage.discharging_slope));
    double low = -HUGE_VAL, high = HUGE_VAL, u = start, slope = 1.0;
    double reach = 4.0 / steepest;  // the exponentials change by e^4 over it
    for (int k = 0; k < 400; ++k) {
      const Slope f = at(u);
      slope = f.slope();
      (f.value() > 0.0 ? high : low) = u;
      double step = -f.value() / slope;
      if (std::abs(step) > reach) {
        step = std::copysign(reach, step);
        reach *= 2.0;
      }
      if (std::abs(step) < kSettled + 1e-15 * std::abs(u)) {
        u += step;
        break;
      }
      double next = u + step;
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      if (next == u) break;
      u = next;
    }
    return {u, slope, activity.slope()};
  }

  /// @return [V], how far one step and two halves part; both are left in their buffers.
  double attempt(const S* p, const Present<S>& present, const S& current, double h) {
    const double begin = valueOf(before_[0]);
    const double moved = rate_ * h;
    const double guess = std::abs(moved) < kMaxMoved ? begin + moved : begin;
    euler(p, present, current, h, guess, before_, whole_);
    euler(p, present, current, 0.5 * h, 0.5 * (begin + valueOf(whole_[0])), before_, half_);
    euler(p, present, current, 0.5 * h, valueOf(whole_[0]), half_, halves_);
    double error = std::abs(valueOf(whole_[0]) - valueOf(halves_[0]));
    if (has_activity_)
      error +=
          std::abs(std::log(valueOf(whole_[1]) / valueOf(halves_[1]))) / valueOf(charging_slope_);
    return error;
  }

  std::vector<BoundComposition::Member> side_;
  BoundComposition::Member activity_{nullptr, 0, 0};
  bool has_activity_, has_ladder_, is_limited_, is_prepared_ = false, is_symmetric_ = false;
  std::vector<S> before_, whole_, half_, halves_;  // u, p, ladder
  std::vector<Ladder<S>> ladder_;
  double dispersion_ = -1.0;
  double rate_ = 0.0;                                       // of u in the last step [V/s]
  S storage_ = S(0.0), offset_ = S(0.0);                    // of a step [1/Ohm], [A]
  double activity_slope_ = 0.0;                             // to u, at a source [1/V]
  S charging_slope_ = S(0.0), discharging_slope_ = S(0.0);  // alpha beta, (1 - alpha) beta [1/V]
  Slope charging_slope_value_ = Slope(0.0), discharging_slope_value_ = Slope(0.0);
  Present<Slope> present_slope_;
  std::vector<std::vector<Slope>> side_slopes_;
  std::vector<Slope> activity_slopes_;
};

}  // namespace battery_sof
