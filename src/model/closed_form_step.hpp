#pragma once

#include <cmath>

#include "model/instruction_sets.hpp"

namespace battery_sof {

/// What the exact step needs of a held current, with R = sqrt(i^2 + 4 I_0^2).
struct CurrentShares {
  double charging;     ///< (R + i) / (2R), in (0, 1)
  double discharging;  ///< (R - i) / (2R), in (0, 1)
  double mixed;        ///< I_0 / R, in (0, 1/2]
  double R;            ///< [A]
};

/// @param current [A].  @param i0 exchange current [A], > 0.
BATTERY_SOF_INLINE CurrentShares sharesOf(double current, double i0) {
  const double R = std::sqrt(current * current + 4.0 * i0 * i0);
  // The larger share of |i|, then mirrored for discharges: nothing cancels.
  const double inverse = 1.0 / R;
  const double mixed = i0 * inverse;
  const double larger = 0.5 + 0.5 * std::abs(current) * inverse;
  const double smaller = mixed * mixed / larger;
  return {current < 0.0 ? smaller : larger, current < 0.0 ? larger : smaller, mixed, R};
}

/**
 * @brief The exact step of the base model's state for alpha = 0.5, written once for one sample and
 * for several side by side.
 *
 * With E = exp(beta u_c2 / 2) = x / y, D = exp(-decay), P = 1 - D, decay = beta R dt / (2 C_2) and
 * the shares above,
 *
 *     x' = (charging + D discharging) x + P mixed y
 *     y' = P mixed x + (discharging + D charging) y
 *
 * a symmetric contraction with the eigenvalues 1 and D: every term is positive, and no step waits
 * for a division. Its determinant D makes the derivatives as simple:
 *
 *     x' y' dlnE'/dlnE = D x y,   x' y' dlnE'/dD = mixed (x^2 - y^2) + (discharging - charging) x y
 *
 * See OverpotentialStep for the differential equation.
 * @tparam T double, a Register of doubles (element by element), or an automatic-differentiation
 * scalar.
 */
template <typename T>
struct ClosedFormStep {
  T charging, discharging, mixed;  ///< see CurrentShares
  T D;                             ///< in [0, 1]
  T P;                             ///< 1 - D

  BATTERY_SOF_INLINE T xFromX() const { return charging + D * discharging; }
  BATTERY_SOF_INLINE T yFromY() const { return discharging + D * charging; }
  BATTERY_SOF_INLINE T across() const { return P * mixed; }  ///< x from y, and y from x
  BATTERY_SOF_INLINE T nextX(const T& x, const T& y) const { return xFromX() * x + across() * y; }
  BATTERY_SOF_INLINE T nextY(const T& x, const T& y) const { return across() * x + yFromY() * y; }
  /// x' y' dlnE'/dD.
  BATTERY_SOF_INLINE T slopeToD(const T& x, const T& y) const {
    return mixed * (x * x - y * y) + (discharging - charging) * x * y;
  }
};

/**
 * @brief The exact step of w = beta u_c2 under a held current, for any scalar.
 *
 * @param w         beta u_c2 before [1], |w| <= 1200.
 * @param current   [A].   @param i0 exchange current [A], > 0.
 * @param half_rate beta dt / (2 C_2) [1/A], >= 0.
 * @return beta u_c2 after [1].
 */
template <typename S>
S closedFormAdvance(const S& w, const S& current, const S& i0, const S& half_rate) {
  using std::abs;
  using std::exp;
  using std::log;
  using std::sqrt;
  const S R = sqrt(S(current * current + 4.0 * i0 * i0));
  const S mixed = S(i0 / R);
  const bool discharging = current < 0.0;
  const S larger = S(0.5 + (discharging ? -0.5 : 0.5) * current / R);
  const S smaller = S(mixed * mixed / larger);
  const S D = exp(S(-half_rate * R));
  const ClosedFormStep<S> step{discharging ? smaller : larger, discharging ? larger : smaller,
                               mixed, D, S(1.0 - D)};
  const S x = exp(S(0.25 * w));
  const S y = S(1.0 / x);
  return S(2.0 * log(S(step.nextX(x, y) / step.nextY(x, y))));
}

}  // namespace battery_sof
