#pragma once

#include <algorithm>
#include <cmath>

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

}  // namespace battery_sof
