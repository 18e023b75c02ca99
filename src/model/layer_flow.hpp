#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "bound_composition.hpp"
#include "layer_parts.hpp"

namespace battery_sof {

/**
 * @brief A current through the double layer near some voltage u_0: its value, and the two
 * exponentials that follow it from there.
 *
 *     f(u_0 + d) ~ value + rising (exp(k d) - 1) - falling (exp(-k d) - 1)
 *
 * agrees with f in value, slope k (rising + falling) and curvature k^2 (rising - falling). Both are
 * >= 0 where |f''| <= k f'.
 */
template <typename S>
struct MatchedCurrent {
  S value, rising, falling;  ///< [A]
};

/// Where a flow ends.
template <typename S>
struct FlowEnd {
  S moved;   ///< d [V]
  S growth;  ///< exp(k d) [1]
};

/**
 * @brief The exact step of a capacitor under a held current, its own current as matched at the
 * step's beginning.
 *
 *     C dd/dt = i - value - rising (exp(k d) - 1) + falling (exp(-k d) - 1),   d(0) = 0
 *
 * With I = i - value + rising - falling, R^2 = I^2 + 4 rising falling and z = k R t / (2 C),
 *
 *     d(t) = ln[ (R coth z + I + 2 falling) / (R coth z - I + 2 rising) ] / k
 *
 * For the base reaction at alpha = 0.5 it is ClosedFormStep itself, however long the step; for
 * other currents the error of a step goes with its fourth power. It settles where the matched
 * current does: no step is too long.
 *
 * @param rate 2 C / (k t) [A], > 0.
 */
template <typename S>
FlowEnd<S> matchedFlow(const MatchedCurrent<S>& at, const S& current, const S& k, const S& rate) {
  using std::exp;
  using std::log;
  using std::sqrt;
  constexpr double kShort = 1e-2;  // [1], of z; below it the series of z coth z is exact to 1e-14
  const S I = S(current - ((at.value - at.rising) + at.falling));
  const S square = S(I * I + 4.0 * at.rising * at.falling);
  S spread;  // R coth z
  if (square < S(kShort * kShort * rate * rate)) {
    const S z_square = S(square / (rate * rate));
    spread = S(rate * (1.0 + z_square * (1.0 / 3.0 - z_square / 45.0)));
  } else {
    const S R = S(sqrt(square));
    const S D = S(exp(S(-2.0 * R / rate)));
    spread = S(R * (1.0 + D) / (1.0 - D));
  }
  const S growth = S((spread + I + 2.0 * at.falling) / (spread - I + 2.0 * at.rising));
  return {S(log(growth) / k), growth};
}

/**
 * @brief Matched steps of the double layer's voltage alone (matchedFlow()), as long as the current
 * at their end is the one that was assumed. For layers without activity and ladder.
 */
template <typename S>
struct LayerFlow {
  /// their currents go past the reaction
  const std::vector<BoundComposition::Member>& side;
  const S* p;  ///< all parameters
  const Present<S>& present;
  const S &charging_slope, &discharging_slope;  ///< alpha beta, (1 - alpha) beta [1/V]
  /// an effect sets Present::reactivity and inverse_supply
  bool is_limited;
  bool is_symmetric;  ///< alpha is a half

  /// Passes through an interval under a held current. @param pace updated.  @param u [V], updated.
  void advance(const S& current, double duration, LayerPace& pace, S& u) const {
    const bool charging_is_steeper = valueOf(charging_slope) >= valueOf(discharging_slope);
    const S k = charging_is_steeper ? charging_slope : discharging_slope;
    const S storage = S(2.0 * present.c2 / k);
    MatchedCurrent<S> at = currentAt(u, k);
    double left = duration;
    double& step = pace.step;
    for (StepsTaken taken(pace); left > 0.0;) {
      const double h = taken.next(left, step);
      const double tolerance = scaledTolerance(kFlowTolerance, valueOf(u), valueOf(charging_slope));
      const FlowEnd<S> end = matchedFlow(at, current, k, S(storage * (1.0 / h)));
      const S next = S(u + end.moved);
      const MatchedCurrent<S> after = currentAt(next, k);
      const double grown = valueOf(end.growth);
      const double assumed = valueOf(at.value) + valueOf(at.rising) * (grown - 1.0) -
                             valueOf(at.falling) * (1.0 / grown - 1.0);
      const double slope = valueOf(k) * (valueOf(after.rising) + valueOf(after.falling));
      const double error =
          flowError(valueOf(after.value) - assumed, slope, h / valueOf(present.c2));
      const double wanted =
          h * std::clamp(0.9 * std::sqrt(std::sqrt(tolerance / std::max(error, 1e-12))), 0.2, 4.0);
      const bool accepted = taken.accept(h, error <= tolerance);
      if (accepted) {
        u = next;
        at = after;
        left -= h;
      }
      step = std::max(accepted && h < step ? std::max(wanted, step) : wanted, kShortestStep);
    }
  }

 private:
  static constexpr double kFlowTolerance = 2e-6;  // [V], what a matched step misses
  static constexpr double kSecant = 1e-3;         // [V], over which a side current's slope is taken

  /// @return [V]: a current that is missed in the end by `missed` and began right has been missed
  /// by as much as grows with the third power of time; over long steps the layer settles where it
  /// is not.
  static double flowError(double missed, double slope, double inverse_rate) {
    const double error = std::abs(missed) * inverse_rate / (4.0 + slope * inverse_rate);
    return std::isfinite(error) ? error : HUGE_VAL;
  }

  /// What flows through the layer around u. @param k [1/V], of the exponentials that represent it.
  MatchedCurrent<S> currentAt(const S& u, const S& k) const {
    using std::exp;
    const S risen = S(exp(bounded(S(charging_slope * u))));
    const S charging =
        is_limited ? S(present.i0 * present.reactivity * risen) : S(present.i0 * risen);
    const S discharging = is_symmetric ? S(present.i0 / risen)
                                       : S(present.i0 * exp(bounded(S(-discharging_slope * u))));
    MatchedCurrent<S> at =
        is_limited ? limitedAt(charging, discharging, k) : reactionAt(charging, discharging, k);
    for (const BoundComposition::Member& bound : side) {
      const S here = kernelOf(*bound.effect, u).sideCurrent(p + bound.parameter, u, present);
      const S beyond =
          kernelOf(*bound.effect, u).sideCurrent(p + bound.parameter, S(u + kSecant), present);
      const S half_slope = S((beyond - here) * (0.5 / kSecant) / k);
      at.value = S(at.value + here);
      at.rising = S(at.rising + half_slope);
      at.falling = S(at.falling + half_slope);
    }
    return at;
  }
  MatchedCurrent<S> reactionAt(const S& charging, const S& discharging, const S& k) const {
    if (is_symmetric) return {S(charging - discharging), charging, discharging};
    const S a = S(charging_slope / k), b = S(discharging_slope / k);
    return {S(charging - discharging),
            S(0.5 * (a * (1.0 + a) * charging + b * (1.0 - b) * discharging)),
            S(0.5 * (a * (1.0 - a) * charging + b * (1.0 + b) * discharging))};
  }
  /// Of the reaction with a limited supply; slope and curvature in units of k and its square.
  MatchedCurrent<S> limitedAt(const S& charging, const S& discharging, const S& k) const {
    const S a = S(charging_slope / k), b = S(discharging_slope / k);
    const S fed = S(a * charging * present.inverse_supply),
            share = S(1.0 / (1.0 + charging * present.inverse_supply));
    const S value = S((charging - discharging) * share);
    const S slope = S((a * charging + b * discharging - value * fed) * share);
    const S curvature =
        S((a * a * charging - b * b * discharging - 2.0 * slope * fed - value * a * fed) * share);
    return {value, positivePart(S(0.5 * (slope + curvature))),
            positivePart(S(0.5 * (slope - curvature)))};
  }
};

}  // namespace battery_sof
