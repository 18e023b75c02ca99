#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "effects/effect_definition.hpp"
#include "model/closed_form_slopes.hpp"
#include "model/steps_taken.hpp"

namespace battery_sof {

/// An effect that takes part in the double layer's implicit step.
struct BoundEffect {
  const Effect* effect;
  int first_parameter;
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
template <typename D>
bool isHalf(const Eigen::AutoDiffScalar<D>& alpha) {
  return alpha.value() == 0.5 && (alpha.derivatives().array() == 0.0).all();
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
    u.derivatives() = to_w * u.derivatives() + (after.to_current / beta) * current.derivatives() +
                      ((to_w * w + rate - after.w) / (beta * beta)) * present.beta.derivatives() -
                      (rate / (beta * c2)) * present.c2.derivatives() +
                      (after.to_i0 / beta) * present.i0.derivatives();
    u.value() = after.w / beta;
  }
}

/// Values alone, for the solver of an implicit step.
template <typename S>
Present<Slope> toSlope(const Present<S>& f) {
  const auto v = [](const S& x) { return Slope(valueOf(x)); };
  return {v(f.r_discharge), v(f.r_charge),       v(f.c2),         v(f.beta),    v(f.u_dc),
          v(f.i0),          v(f.alpha),          v(f.acceptance), v(f.warming), v(f.dispersion),
          v(f.reactivity),  v(f.inverse_supply), f.time};
}

}  // namespace battery_sof
