#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>

#include "cloned.hpp"
#include "model/double_layer.hpp"
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
  /// [A], from what was tried last to where the slope says it ends
  double step() const { return step_; }

  /// Whether what was tried is the most that may flow and leaves the voltage below the wanted one.
  bool isLimited(double excess) const { return current_ >= most_ && excess <= 0.0; }

  /// @param excess [V], of the voltage at current() over the wanted one.  @param resistance [Ohm],
  /// its slope there.
  void take(double excess, double resistance) {
    (excess > 0.0 ? high_ : low_) = current_;
    const double before = step_;
    step_ = -excess / resistance;
    if (trials_++ > 0 && before != 0.0)
      bend_ = std::min(std::abs(step_) / (before * before), kMaxBend);
    double next = std::min(current_ + step_, most_);
    const double top = std::min(high_, most_);
    if (!(std::abs(step_) < kLastStep) && !(next > low_ && next < high_))
      next = 0.5 * (std::max(low_, top - kReach) + top);
    tried_ = current_;
    current_ = next;
  }

  /// Whether the last step ends where the voltage is the wanted one. At no current the resistance
  /// jumps: no slope reaches across.
  bool isThere(double last_step = kLastStep) const {
    return std::abs(step_) < (crossesZero() ? std::min(last_step, kLastAcross) : last_step);
  }
  /// Whether the trial to come is likely to be the last.
  bool isNear() const {
    return isThere() ||
           (!crossesZero() && bend_ * step_ * step_ < kLastStep && current_ == tried_ + step_);
  }

  /// [1/A], error a step leaves, over its square, as this search has seen it; what the next one may
  /// expect.
  double bend() const { return bend_; }
  void expectBend(double bend) { bend_ = bend; }

 private:
  static constexpr double kReach = 1e4;        // [A], below the bracket's upper end
  static constexpr double kLastAcross = 1e-5;  // [A]
  static constexpr double kMaxBend = 0.2;      // [1/A]

  bool crossesZero() const { return (tried_ < 0.0) != (tried_ + step_ < 0.0); }

  double most_, current_, tried_ = 0.0, step_ = 0.0;
  double low_ = -HUGE_VAL, high_ = HUGE_VAL;
  double bend_ = kMaxBend;
  int trials_ = 0;
};

/// What a source leaves behind for its next interval.
template <typename S>
struct SourceMemory {
  S current = S(0.0);  ///< [A], of the last interval
  /// [A] that the current and [V] that the voltage moved in it
  double trend = 0.0, move = 0.0;
  double resistance = 0.0, bend = 0.2;  ///< [Ohm] over it; [1/A] as SourceSearch::bend()

  struct Work {
    std::unique_ptr<Stepper<Slope>> probe;  ///< the same battery, for trials of currents
    StepTrail trail;
    SimulationState<S> kept;  ///< where a trial in arithmetic S began
  };
  WorkSpace<Work> work;

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
    battery_.widen();  // the current's tangents reach the double layer
    if (bound.limits_reaction && bound.activity_state < 0 && bound.ladder_state < 0 &&
        !bound.steps_finely && stepAtSource(voltage, duration, max_current))
      return valueOf(memory_.current);
    return advanceBySearch(voltage, duration, max_current);
  }

  /// As Simulation::resistanceOver().
  double resistanceOver(double current, double duration) {
    trail().clear();
    excessOf(current, 0.0, duration);
    return probeResistance();
  }

 private:
  static constexpr int kWidth = Width<S>::value;
  static constexpr double kLastStepByProbe = 1e-5;  // [A], where derivatives are the last trial's
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
  bool stepAtSource(const S& voltage, double duration, double max_current) {
    const double middle = now_.time + duration - 0.5 * duration;
    const Present<S> present = battery_.presentAt(middle);
    Stepper<Slope>& slopes = probe();
    const Present<Slope> slope_present = slopes.presentAt(middle);
    const Eliminated found = eliminate(valueOf(voltage), duration, present, slope_present);
    const double i = found.step.current, resistance = found.resistance;
    if (!found.is_found || i > max_current || !std::isfinite(i)) return false;
    // In arithmetic S one Newton step for (u, i) adds the derivatives: B du - di = -a, du + R di =
    // -b.
    const S held(i), u(found.step.u);
    const S a = battery_.layer().imbalance(battery_.effects().parameters().data(), present, held,
                                           duration, now_.x[0], found.step.u);
    const S b = S(battery_.othersVoltage(held, duration, u, present) + u - voltage);
    // d(voltage) / du, i held
    const double grip = battery_.discrepancy() ? 1.0 + slopes.discrepancySlope(
                                                           i, duration, found.step.u, slope_present)
                                               : 1.0;
    const S du = S((a + b * (1.0 / resistance)) * (-1.0 / (found.step.slope + grip / resistance)));
    const S mean = S(0.5 * (now_.x[0] + u + du));
    memory_.forgetTrend();
    memory_.current = S(held - (b + grip * du) * (1.0 / resistance));
    battery_.passKnown(memory_.current, S(u + du), mean, duration, present);
    return true;
  }

  Eliminated eliminate(double voltage, double duration, const Present<S>& present,
                       const Present<Slope>& slope_present) {
    Stepper<Slope>& slopes = *work().probe;
    const double before = valueOf(now_.x[0]);
    double i = valueOf(memory_.current);
    Eliminated found;
    SourceStep& step = found.step;
    for (int k = 0; k < kMaxRounds && !found.is_found; ++k) {
      const Slope others =
          slopes.othersVoltage(Slope(i, Eigen::Matrix<double, 1, 1>::Ones()), duration,
                               Slope(k > 0 ? step.u : before), slope_present);
      found.resistance = others.derivatives()[0];
      step = battery_.layer().atSource(battery_.effects().parameters().data(), present,
                                       voltage - others.value() + found.resistance * i,
                                       found.resistance, duration, before);
      found.is_found = std::abs(step.current - i) < kSettledCurrent * (1.0 + std::abs(i));
      i = step.current;
    }
    return found;
  }

  // ---------------------------------------------------------------------- search for the current that is held

  /// Holds the current that ends at the voltage. Trials go in the probe; the last step of the
  /// search is taken in arithmetic S.
  double advanceBySearch(const S& voltage, double duration, double max_current) {
    const double wanted = valueOf(voltage), before = now_.last_current;
    const double move = valueOf(now_.terminal) != 0.0 ? wanted - valueOf(now_.terminal) : 0.0;
    SourceSearch search(firstCurrent(move), max_current);
    search.expectBend(memory_.bend);
    trail().clear();
    bool done = false;
    for (int k = 0; k < SourceSearch::kMaxTrials && !done; ++k) {
      const double tried = search.current(), excess = excessOf(tried, wanted, duration);
      if (search.isLimited(excess)) {
        holdAtMost(tried, duration);
        break;
      }
      search.take(excess, probeResistance());
      const bool is_last = k + 1 == SourceSearch::kMaxTrials || !std::isfinite(excess);
      done = is_last ? adopt(voltage, duration, tried, search)
                     : land(voltage, duration, tried, search);
    }
    memory_.bend = search.bend();
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

  /// Ends a search where it is about to. @return false, nothing moved, when it has to go on.
  bool land(const S& voltage, double duration, double tried, SourceSearch& search) {
    if constexpr (std::is_same_v<S, double>)
      return search.isThere() && adopt(voltage, duration, tried, search);
    if (battery_.tangents() == kWidth)
      return search.isThere(kLastStepByProbe) && adopt(voltage, duration, tried, search);
    return search.isNear() && passAlong(voltage, duration, search);
  }

  /// Ends where the probe ended, and what its slopes make of the last step.
  bool adopt(const S& voltage, double duration, double tried, const SourceSearch& search) {
    memory_.current = S(search.current());
    if constexpr (std::is_same_v<S, double>) {
      takeProbe(search.current() - tried);
    } else {
      passAsTried(memory_.current, duration);
      letCurrentFollow(voltage);
    }
    return true;
  }
  void holdAtMost(double max_current, double duration) {
    memory_.current = S(max_current);
    if constexpr (std::is_same_v<S, double>)
      takeProbe(0.0);
    else
      passAsTried(memory_.current, duration);
  }

  /// One pass of the hold in arithmetic S, from where the trials know its implicit steps to end.
  void passAsTried(const S& current, double duration) { passOnTrail(battery_, current, duration); }

  template <typename T>
  void passOnTrail(Stepper<T>& battery, const T& current, double duration) {
    trail().begin();
    battery.layer().useTrail(&trail());
    battery.pass(current, current, duration, 0.0, now_.time + duration);
    battery.layer().useTrail(nullptr);
  }

  /// The probe's end with `more` current [A], to first order.
  void takeProbe(double more) {
    const Stepper<Slope>& from = *work().probe;
    standAs(now_, from.now,
            [more](const Slope& x) { return x.value() + x.derivatives()[0] * more; });
    if (from.discrepancy()) battery_.setBeyondIdentified(from.discrepancy()->beyond());
  }

  /**
   * @brief The hold in arithmetic S with the current as one tangent more: Newton's last step, and
   * the implicit function's derivatives.
   *
   * @return false, nothing moved, when that step is longer than a last one may be; `search` goes on
   * from there.
   */
  bool passAlong(const S& voltage, double duration, SourceSearch& search) {
    if constexpr (std::is_same_v<S, double>) {
      return false;
    } else {
      const Eigen::Index own = battery_.tangents();
      SimulationState<S>& kept = work().kept = now_;
      S held(search.current());
      held.derivatives()[own] = 1.0;
      passAsTried(held, duration);
      search.take(valueOf(now_.terminal) - valueOf(voltage), now_.terminal.derivatives()[own]);
      if (search.isThere()) {
        foldCurrent(held, search.current(), voltage);
        return true;
      }
      std::swap(now_, kept);
      return false;
    }
  }

  /// Takes the current's tangent up into the others: it is what keeps the terminal at the voltage.
  /// @param end [A], of the search.
  void foldCurrent(const S& held, double end, const S& voltage) {
    const Eigen::Index own = battery_.tangents();
    S follow = S((voltage - now_.terminal) * (1.0 / now_.terminal.derivatives()[own]));
    follow.value() = end - valueOf(held);
    follow.derivatives()[own] = 0.0;
    const auto fold = [&](S& x) {
      const double slope = x.derivatives()[own];
      x.derivatives()[own] = 0.0;
      x.value() += slope * follow.value();
      x.derivatives() += slope * follow.derivatives();
    };
    memory_.current = held;
    fold(memory_.current);
    changeNumbers(now_, fold);
  }

  /// Lets the current that was solved for follow the tangents so that the terminal voltage stays:
  /// the implicit function's derivative, by the slopes that the probe has to the current.
  void letCurrentFollow(const S& voltage) {
    const S follow = S((valueOf(now_.terminal) - now_.terminal + voltage - valueOf(voltage)) /
                       probeResistance());
    memory_.current = S(memory_.current + follow);
    changeNumbersBeside(now_, work().probe->now, [&](S& x, const Slope& slope) {
      x = S(x + slope.derivatives()[0] * follow);
    });
  }

  // ------------------------------------------------------------------------------------------------- the probe

  typename SourceMemory<S>::Work& work() { return *memory_.work; }
  StepTrail& trail() { return work().trail; }
  double probeResistance() { return work().probe->now.terminal.derivatives()[0]; }

  /// The same battery in the arithmetic of the solver for the current, as it stands.
  Stepper<Slope>& probe() {
    std::unique_ptr<Stepper<Slope>>& same = work().probe;
    if (!same)
      same = std::make_unique<Stepper<Slope>>(battery_.effects().shared(), battery_.point(),
                                              Eigen::MatrixXd());
    standAs(same->now, now_, [](const S& x) { return valueOf(x); });
    return *same;
  }

  /// @return how far a held current ends above a voltage [V]; leaves the probe there.
  double excessOf(double i, double voltage, double duration) {
    passOnTrail(probe(), Slope(i, Eigen::Matrix<double, 1, 1>::Ones()), duration);
    return valueOf(work().probe->now.terminal) - voltage;
  }

  Stepper<S>& battery_;
  SimulationState<S>& now_;
  SourceMemory<S>& memory_;
};

}  // namespace battery_sof
