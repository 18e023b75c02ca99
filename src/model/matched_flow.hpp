#pragma once

#include <cmath>

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

}  // namespace battery_sof
