#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "effects/effect_definition.hpp"
#include "model/closed_form_step.hpp"

namespace battery_sof {

inline constexpr int kUsualSteps = 100;  // in an interval, as many as any battery's takes
inline constexpr int kMaxTried = 2000;   // steps in an interval
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

/// Where an exponent of the reaction stays [1], see Simulation.
inline constexpr double kMaxExponent = 300.0;

/// What may be missed of a voltage u [V]: where parameters have drifted for hours a layer may stand
/// at 1e13 V, and rounding alone misses more than a tolerance in volts. @param charging_slope alpha
/// beta [1/V].
inline double scaledTolerance(double tolerance, double u, double charging_slope) {
  // [V], far beyond any battery: tolerances grow in proportion
  constexpr double kMaxOfLayer = 40.0;
  return tolerance *
         std::max({1.0, std::abs(u) / kMaxOfLayer, 1.0 / (kMaxOfLayer * charging_slope)});
}

/// Whether the reaction is symmetric, whatever the tangents.
inline bool isHalf(double alpha) { return alpha == 0.5; }
template <typename S>
bool isHalf(const S& alpha) {
  return alpha.value() == 0.5 && alpha.isConstant();
}
/// An exponent of the reaction, held where its exponential still is a number.
template <typename T>
T bounded(const T& exponent) {
  const double value = valueOf(exponent);
  return std::abs(value) > kMaxExponent ? T(std::copysign(kMaxExponent, value)) : exponent;
}

/// The exact step of a layer to which nothing is bound: values and slopes in doubles, then one sum
/// over what may carry derivatives.
/// @param u [V], updated.
template <typename S>
void advancePlain(const Present<S>& present, const S& current, double duration, S& u) {
  const double beta = valueOf(present.beta), c2 = valueOf(present.c2),
               half_rate = 0.5 * beta * duration / c2;
  const double wanted = beta * valueOf(u),
               w = std::clamp(wanted, -2.0 * kMaxExponent, 2.0 * kMaxExponent);
  const ClosedFormSlopes after =
      closedFormSlopes(w, valueOf(current), valueOf(present.i0), half_rate);
  if constexpr (std::is_same_v<S, double>) {
    u = after.w / beta;
  } else {
    const double to_w = w == wanted ? after.to_w : 0.0, rate = after.to_half_rate * half_rate;
    u = to_w * u + (after.to_current / beta) * current +
        ((to_w * w + rate - after.w) / (beta * beta)) * present.beta -
        (rate / (beta * c2)) * present.c2 + (after.to_i0 / beta) * present.i0;
    u.value() = after.w / beta;
  }
}

}  // namespace battery_sof
