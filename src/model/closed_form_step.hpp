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
 * The state equation: C_2 du_c2/dt = i - I_0 { exp(beta u_c2 / 2) - exp(-beta u_c2 / 2) } (paper,
 * Fig. 3 and eq. 1); docs/physics.md#base-circuit has the same step as tanh.
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

/// The exact step of w = beta u_c2 and what it answers to.
struct ClosedFormSlopes {
  double w;             ///< after the step [1]
  double to_w;          ///< dw' / dw [1]
  double to_current;    ///< dw' / di [1/A]
  double to_i0;         ///< dw' / dI_0 [1/A]
  double to_half_rate;  ///< dw' / d(beta dt / (2 C_2)) [A]
};

/**
 * @brief closedFormAdvance() with all its derivatives in closed form, for alpha = 0.5.
 *
 * With the symbols of ClosedFormStep, x y = 1, w' = 2 ln(x' / y'), R^2 = i^2 + 4 I_0^2, m = I_0 /
 * R, q = i / R and D = exp(-half_rate R):
 *
 *     dw'/dw = D / (x' y'),   dw'/dD = 2 [m (x^2 - y^2) + (discharging - charging)] / (x' y')
 *     at held D:   dw'/di   = 2 (P m / R) [(2m x - q y) y' + (q x + 2m y) x'] / (x' y')
 *                  dw'/dI_0 = 2 (P q / R) [(q y - 2m x) y' - (q x + 2m y) x'] / (x' y')
 *     dD/di = -half_rate q D,   dD/dI_0 = -4 half_rate m D,   dD/dhalf_rate = -R D
 *
 * @param w beta u_c2 before [1], |w| <= 1200.  @param current [A].  @param i0 [A], > 0.  @param
 * half_rate [1/A], >= 0.
 */
inline ClosedFormSlopes closedFormSlopes(double w, double current, double i0, double half_rate) {
  const CurrentShares shares = sharesOf(current, i0);
  const double R = shares.R, inverse = 1.0 / R, m = shares.mixed, q = current * inverse;
  const double D = std::exp(-half_rate * R), P = 1.0 - D;
  const ClosedFormStep<double> step{shares.charging, shares.discharging, m, D, P};
  const double x = std::exp(0.25 * w), y = 1.0 / x;
  const double x_after = step.nextX(x, y), y_after = step.nextY(x, y);
  const double both = 2.0 / (x_after * y_after);
  const double across_x = 2.0 * m * x - q * y, across_y = q * x + 2.0 * m * y;
  const double to_D = both * step.slopeToD(x, y), held = both * P * inverse;
  // shares move as (m, -q) with (i, I_0)
  const double turned = held * (across_x * y_after + across_y * x_after);
  return {2.0 * std::log(x_after / y_after), 0.5 * both * D, m * turned - to_D * half_rate * q * D,
          -q * turned - to_D * 4.0 * half_rate * m * D, -to_D * R * D};
}

}  // namespace battery_sof
