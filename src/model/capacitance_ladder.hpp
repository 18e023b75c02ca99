#pragma once

#include <array>
#include <cmath>

#include "effects/effect_definition.hpp"
#include "util/pi.hpp"

namespace battery_sof {

/**
 * @brief A fractional capacitance as a capacitance and a ladder of relaxing ones (Foster form;
 * docs/physics.md#constant-phase-element).
 *
 *     C w_c^g d^(1-g) u / dt^(1-g)  =  C [ h du/dt + sum_k l_k (u - v_k) ],   dv_k/dt = w_k (u - v_k)
 *     h = sinc(pi g) (w_c / w_hi)^g,   l_k = g sinc(pi g) w_c^g w_k^(1-g) ln(ratio)
 *
 * on a grid w_k of constant ratio that ends half a step below w_hi; g = 0 gives h = 1 and l_k = 0
 * exactly.
 */
template <typename S>
struct Ladder {
  // w_c [rad/s], keeps the meaning of C: docs/physics.md#cpe2
  static constexpr double kCorner = 0.3;
  static constexpr double kSlowest = 1e-5, kFastest = 1e3;  // [rad/s]

  S head;                            // h [1]
  std::array<S, kLadderRungs> rung;  // l_k [rad/s]

  static double rate(int k) {
    static const std::array<double, kLadderRungs> rates = [] {
      std::array<double, kLadderRungs> all;
      for (int j = 0; j < kLadderRungs; ++j)
        all[j] = kSlowest * std::pow(kFastest / kSlowest, j / (kLadderRungs - 1.0));
      return all;
    }();
    return rates[k];
  }
  static double logRatio() { return std::log(kFastest / kSlowest) / (kLadderRungs - 1); }

  explicit Ladder(const S& dispersion) {
    using std::exp;
    using std::sin;
    const S angle = S(kPi * dispersion);
    const S sinc = valueOf(angle) < 1e-4 ? S(1.0 - angle * angle / 6.0) : S(sin(angle) / angle);
    const double fastest_edge = std::log(kFastest) + 0.5 * logRatio();
    head = S(sinc * exp(S(dispersion * (std::log(kCorner) - fastest_edge))));
    for (int k = 0; k < kLadderRungs; ++k)
      rung[k] = S(dispersion * sinc * exp(S(dispersion * std::log(kCorner / rate(k)))) *
                  (rate(k) * logRatio()));
  }
};

}  // namespace battery_sof
