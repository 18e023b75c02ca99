#pragma once

namespace battery_sof {

inline constexpr double kShortestStep = 1e-7;  // [s], of the double layer
inline constexpr int kUsualSteps = 100;        // in an interval, as many as any battery's takes
inline constexpr int kMaxTried = 2000;         // steps in an interval
// steps beyond the usual ones in a simulation, all intervals together
inline constexpr int kMaxBeyond = 4000;
// shortest steps in an interval that still miss the tolerance
inline constexpr int kMaxMissed = 100;

/// What one interval of a simulation leaves to the next of how the double layer is stepped: part of
/// what makes two runs alike.
struct LayerPace {
  double step = 1.0;        ///< [s], length of the next implicit step as the last ones suggest
  int beyond = kMaxBeyond;  ///< steps that intervals may yet take beyond the usual ones
};

/**
 * @brief The adaptive steps of the double layer in one interval of held current, so far.
 *
 * An interval whose steps come to no end, or of which even the shortest miss the tolerance again
 * and again (a layer that parameters beyond any battery's take to a hundred volts swings for ever),
 * takes its remainder as one step: implicit and matched steps are stable at any length. A
 * simulation of which many intervals take more than usual has fewer for the later ones. So the work
 * of an interval, and with it of an answer, is bounded whatever the parameters are.
 */
struct StepsTaken {
  /// @param of the simulation; steps beyond the usual are taken off it.
  explicit StepsTaken(LayerPace& of) : pace(of) {}

  LayerPace& pace;
  int tried = 0, missed = 0;

  bool areTooMany() const {
    return tried >= kMaxTried || missed >= kMaxMissed || (tried >= kUsualSteps && pace.beyond == 0);
  }

  /// The length of the next step [s]. @param left [s], of the interval.  @param step [s], as the
  /// last ones suggest.
  double next(double left, double step) const {
    return areTooMany() || step > 0.999 * left ? left : step;
  }

  /// Whether a step of h [s] counts; else it is tried again, shorter. @param is_within its error is
  /// within the tolerance.
  bool accept(double h, bool is_within) {
    const bool is_last = areTooMany(), is_shortest = h <= kShortestStep;
    ++tried;
    if (tried > kUsualSteps && pace.beyond > 0) --pace.beyond;
    missed += is_shortest && !is_within;
    return is_within || is_shortest || is_last;
  }
};

}  // namespace battery_sof
