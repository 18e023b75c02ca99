#pragma once

#include <cmath>

#include "model/closed_form_step.hpp"

namespace battery_sof {

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
  const double R = std::sqrt(current * current + 4.0 * i0 * i0), inverse = 1.0 / R;
  const double m = i0 * inverse, q = current * inverse;
  const double larger = 0.5 + 0.5 * std::abs(q), smaller = m * m / larger;
  const double D = std::exp(-half_rate * R), P = 1.0 - D;
  const ClosedFormStep<double> step{current < 0.0 ? smaller : larger,
                                    current < 0.0 ? larger : smaller, m, D, P};
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
