#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>

#include "stepper.hpp"

namespace battery_sof {

/**
 * @brief Newton's method for the current whose held flow ends at a wanted voltage, inside a
 * bracket: the voltage rises with it.
 *
 * Convergence is quadratic, to an error of about 0.2/A of the square of the last step at worst (a
 * settled double layer near rest): a step below kLastStep leaves less than 1e-8 A.
 */
class SourceSearch {
 public:
  static constexpr double kLastStep = 1e-4;  ///< [A]
  static constexpr int kMaxTrials = 100;

  /// @param first where to begin [A].  @param most [A], no current goes beyond.
  SourceSearch(double first, double most) : most_(most), current_(std::min(first, most)) {}

  double current() const { return current_; }  ///< [A], to be tried

  /// Whether what was tried is the most that may flow and leaves the voltage below the wanted one.
  bool isLimited(double excess) const { return current_ >= most_ && excess <= 0.0; }

  /// @param excess [V], of the voltage at current() over the wanted one.  @param resistance [Ohm],
  /// its slope there.
  void take(double excess, double resistance) {
    (excess > 0.0 ? high_ : low_) = current_;
    step_ = -excess / resistance;
    double next = std::min(current_ + step_, most_);
    const double top = std::min(high_, most_);
    if (!(std::abs(step_) < kLastStep) && !(next > low_ && next < high_))
      next = 0.5 * (std::max(low_, top - kReach) + top);
    tried_ = current_;
    current_ = next;
  }

  /// Whether the last step ends where the voltage is the wanted one. At no current the resistance
  /// jumps: no slope reaches across.
  bool isThere(double last_step) const {
    return std::abs(step_) < (crossesZero() ? std::min(last_step, kLastAcross) : last_step);
  }

 private:
  static constexpr double kReach = 1e4;        // [A], below the bracket's upper end
  static constexpr double kLastAcross = 1e-5;  // [A]

  bool crossesZero() const { return (tried_ < 0.0) != (tried_ + step_ < 0.0); }

  double most_, current_, tried_ = 0.0;
  double step_ = 0.0;  // [A], from what was tried last to where the slope says it ends
  double low_ = -HUGE_VAL, high_ = HUGE_VAL;
};

/// What a source leaves behind for its next interval.
template <typename S>
struct SourceMemory {
  S current = S(0.0);  ///< [A], of the last interval
  /// [A] that the current and [V] that the voltage moved in it
  double trend = 0.0, move = 0.0;
  double resistance = 0.0;  ///< [Ohm] over it
  /// the same battery, for trials of currents
  WorkSpace<std::unique_ptr<Stepper<Slope>>> probe;

  /// After an interval in which a current was given.
  void forgetTrend() { trend = move = 0.0; }
};

/**
 * @brief A source of the terminal voltage: finds the current that flows, and moves the battery on
 * under it. In arithmetic S the current follows the tangents as the implicit function's derivative.
 */
template <typename S>
class VoltageSource {
 public:
  VoltageSource(Stepper<S>& battery, SourceMemory<S>& memory)
      : battery_(battery), now_(battery.now), memory_(memory) {}

  /// As Simulation::advanceAtVoltage(), to a voltage that may follow the tangents itself.
  double advanceTo(const S& voltage, double duration, double max_current) {
    const BoundComposition& bound = battery_.effects().bound();
    DoubleLayer<S>& layer = battery_.layer();
    if ((bound.limits_reaction || bound.activity_state >= 0 || bound.ladder_state >= 0) &&
        stepAtSource(voltage, duration, max_current, layer))
      return valueOf(memory_.current);
    return advanceBySearch(voltage, duration, max_current);
  }

  /// As Simulation::resistanceOver().
  double resistanceOver(double current, double duration) {
    excessOf(current, 0.0, duration);
    return probeResistance();
  }

 private:
  static constexpr bool kIsOfValues = std::is_same_v<S, double>;
  // [A], less where derivatives are taken at the last trial's current
  static constexpr double kLastStep = kIsOfValues ? SourceSearch::kLastStep : 1e-5;
  static constexpr int kMaxRounds = 20;
  // [A], and share, by which the last round may have moved it
  static constexpr double kSettledCurrent = 1e-7;

  // ------------------------------------------------------------------------------------- one implicit step

  /// A step with the current eliminated, in values.
  struct Eliminated {
    SourceStep step;
    double resistance = 0.0;  // [Ohm], of all but the double layer
    bool is_found = false;
  };

  /**
   * @brief One implicit Euler step of double layer and effects.
   *
   * The current is eliminated: what the other effects and the ohmic resistance make of it is affine
   * in it, or is made so by Newton's method. @return false, nothing moved, when the current would
   * exceed max_current or is not found.
   */
  bool stepAtSource(const S& voltage, double duration, double max_current, DoubleLayer<S>& layer) {
    const double middle = now_.time + duration - 0.5 * duration;
    const Present<S> present = battery_.presentAt(middle);
    Stepper<Slope>& slopes = probe();
    const Present<Slope> slope_present = slopes.presentAt(middle);
    layer.beginStep(battery_.effects().parameters().data(), present, duration, now_.x[0],
                    battery_.activity(), battery_.ladder());
    const Eliminated found = eliminate(valueOf(voltage), duration, layer, slope_present);
    const double i = found.step.current, resistance = found.resistance;
    if (!found.is_found || i > max_current || !std::isfinite(i)) return false;
    // In arithmetic S one Newton step for (u, i) adds the derivatives: B du - di = -a, du + R di =
    // -b.
    const S held(i), u(found.step.u);
    const S a = layer.imbalance(battery_.effects().parameters().data(), present, held, duration,
                                found.step.u);
    const S b = S(battery_.othersVoltage(held, duration, u, present) + u - voltage);
    // d(voltage) / du, i held
    const double grip = battery_.discrepancy() ? 1.0 + slopes.discrepancySlope(
                                                           i, duration, found.step.u, slope_present)
                                               : 1.0;
    const S du = S((a + b * (1.0 / resistance)) * (-1.0 / (found.step.slope + grip / resistance)));
    const S mean = S(0.5 * (now_.x[0] + u + du));
    memory_.forgetTrend();
    memory_.current = S(held - (b + grip * du) * (1.0 / resistance));
    layer.endStep(duration, found.step.u, du, battery_.activity(), battery_.ladder());
    battery_.passKnown(memory_.current, S(u + du), mean, duration, present);
    return true;
  }

  Eliminated eliminate(double voltage, double duration, DoubleLayer<S>& layer,
                       const Present<Slope>& slope_present) {
    Stepper<Slope>& slopes = **memory_.probe;
    const double before = valueOf(now_.x[0]);
    double i = valueOf(memory_.current);
    Eliminated found;
    SourceStep& step = found.step;
    for (int k = 0; k < kMaxRounds && !found.is_found; ++k) {
      const Slope others = slopes.othersVoltage(Slope::unknown(i), duration,
                                                Slope(k > 0 ? step.u : before), slope_present);
      found.resistance = others.slope();
      step = layer.stepAtSource(voltage - others.value() + found.resistance * i, found.resistance,
                                duration);
      found.is_found = std::abs(step.current - i) < kSettledCurrent * (1.0 + std::abs(i));
      i = step.current;
    }
    return found;
  }

  // ---------------------------------------------------------------------- search for the current that is held

  /// Holds the current that ends at the voltage. Trials go in the probe; the battery passes once,
  /// at the current where they end.
  double advanceBySearch(const S& voltage, double duration, double max_current) {
    const double wanted = valueOf(voltage), before = now_.last_current;
    const double move = valueOf(now_.terminal) != 0.0 ? wanted - valueOf(now_.terminal) : 0.0;
    SourceSearch search(firstCurrent(move), max_current);
    for (int k = 0; k < SourceSearch::kMaxTrials; ++k) {
      const double tried = search.current(), excess = excessOf(tried, wanted, duration);
      const bool is_limited = search.isLimited(excess);
      if (!is_limited) search.take(excess, probeResistance());
      const bool is_last = is_limited || k + 1 == SourceSearch::kMaxTrials ||
                           !std::isfinite(excess) || search.isThere(kLastStep);
      if (!is_last) continue;
      adopt(search.current(), tried, duration);
      if (!is_limited) letCurrentFollow(voltage);
      break;
    }
    now_.last_current = valueOf(memory_.current);
    memory_.trend = before != 0.0 ? now_.last_current - before : 0.0;
    memory_.move = move;
    memory_.resistance = probeResistance();
    return now_.last_current;
  }

  /// What flows next: the trend goes on, but for what the voltage moves otherwise than it did.
  double firstCurrent(double move) const {
    return now_.last_current + memory_.trend +
           (memory_.resistance > 0.0 ? (move - memory_.move) / memory_.resistance : 0.0);
  }

  /// Ends under a current: in values where the probe ended, and what its slopes make of the last
  /// step; else by a pass of the battery itself.
  void adopt(double current, double tried, double duration) {
    memory_.current = S(current);
    if constexpr (kIsOfValues) {
      const Stepper<Slope>& from = **memory_.probe;
      standAs(now_, from.now,
              [&](const Slope& x) { return x.value() + x.slope() * (current - tried); });
      if (from.discrepancy()) battery_.setBeyondIdentified(from.discrepancy()->beyond());
    } else {
      battery_.pass(memory_.current, memory_.current, duration, 0.0, now_.time + duration);
    }
  }

  /// Lets the current that was solved for follow the tangents so that the terminal voltage stays:
  /// the implicit function's derivative, by the slopes that the probe has to the current.
  void letCurrentFollow(const S& voltage) {
    if constexpr (kIsOfValues) return;
    const S follow = S((valueOf(now_.terminal) - now_.terminal + voltage - valueOf(voltage)) /
                       probeResistance());
    memory_.current = S(memory_.current + follow);
    changeNumbersBeside(now_, (**memory_.probe).now,
                        [&](S& x, const Slope& slope) { x = S(x + slope.slope() * follow); });
  }

  // ------------------------------------------------------------------------------------------------- the probe

  double probeResistance() { return (**memory_.probe).now.terminal.slope(); }

  /// The same battery in the arithmetic of the solver for the current, as it stands.
  Stepper<Slope>& probe() {
    std::unique_ptr<Stepper<Slope>>& same = *memory_.probe;
    if (!same)
      same = std::make_unique<Stepper<Slope>>(battery_.effects().shared(), battery_.point(),
                                              Eigen::MatrixXd());
    standAs(same->now, now_, [](const S& x) { return valueOf(x); });
    return *same;
  }

  /// @return how far a held current ends above a voltage [V]; leaves the probe there.
  double excessOf(double i, double voltage, double duration) {
    const Slope held = Slope::unknown(i);
    probe().pass(held, held, duration, 0.0, now_.time + duration);
    return valueOf((**memory_.probe).now.terminal) - voltage;
  }

  Stepper<S>& battery_;
  SimulationState<S>& now_;
  SourceMemory<S>& memory_;
};

}  // namespace battery_sof
