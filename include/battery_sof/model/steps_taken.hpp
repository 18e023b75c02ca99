#pragma once

namespace battery_sof {

inline constexpr double kShortestStep = 1e-7;  // [s], of the double layer
inline constexpr int kMostTried = 2000;        // steps in an interval, far above what any battery's takes (a hundred)
inline constexpr int kMostMissed = 100;        // shortest steps in an interval that still miss the tolerance

/**
 * @brief The adaptive steps of the double layer in one interval of held current, so far.
 *
 * An interval whose steps come to no end, or of which even the shortest miss the tolerance again and again (a layer that parameters
 * beyond any battery's take to a hundred volts swings for ever), takes what is left as one step: implicit and matched steps are
 * stable at any length. So the work of an interval, and with it of an answer, is bounded whatever the parameters are.
 */
struct StepsTaken {
  int tried = 0, missed = 0;

  bool areTooMany() const { return tried >= kMostTried || missed >= kMostMissed; }

  /// The length of the next step [s]. @param left [s], of the interval.  @param step [s], as the last ones suggest.
  double next(double left, double step) const { return areTooMany() || step > 0.999 * left ? left : step; }

  /// Whether a step of h [s] counts; else it is tried again, shorter. @param is_within its error is within the tolerance.
  bool accept(double h, bool is_within) {
    const bool is_last = areTooMany(), is_shortest = h <= kShortestStep;
    ++tried;
    missed += is_shortest && !is_within;
    return is_within || is_shortest || is_last;
  }
};

}  // namespace battery_sof
