#include "effect_definition.hpp"

namespace battery_sof {

struct FastArc {
  static constexpr bool kActsAtEdges = true;

  static EffectInfo info() {
    return {"fast_arc",
            "S2",
            "a fast polarisation that the circuit takes for resistance",
            "tau dv/dt = R_h i - v,  u += v",
            {linearStrength("arc_resistance", "R_h", "ohm", 0.001, 0.0, 0.01,
                            "docs/physics.md#fast_arc"),
             shape("arc_time", "tau", "s", 0.05, 0.005, 2.0, 0.8, "docs/physics.md#fast_arc")},
            {{"arc_current", "A"}},
            {"sensor_lag", "time_skew", "inductance"},
            "sampling at 1 kHz, or a resistor on the same channels",
            {},
            {},
            {"sensor_lag"}};
  }
  // The state is v / R_h, so that a vanishing R_h leaves it well defined.
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    x[0] = relaxed(x[0], passage.current, p[1], passage.duration);
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>&) {
    return S(p[0] * x[0]);
  }
};

Effect fastArc() { return effectOf<FastArc>(); }

}  // namespace battery_sof
