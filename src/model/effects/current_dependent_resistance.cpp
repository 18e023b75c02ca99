#include "effect_definition.hpp"

namespace battery_sof {

struct CurrentDependentResistance {
  static EffectInfo info() {
    return {"current_dependent_resistance",
            "S3",
            "the ohmic resistance falls with current",
            "u += r_x i / (1 + |i| / i_x)\n"
            "r(i) = mean + (r_charge - r_discharge) / 2 tanh((i - i_s) / i_w) where i_w > 0",
            {linearStrength("low_current_resistance", "r_x", "ohm", 0.003, 0.0, 0.02,
                            "docs/physics.md#current_dependent_resistance"),
             shape("resistance_current", "i_x", "A", 30.0, 3.0, 150.0, 0.5,
                   "docs/physics.md#current_dependent_resistance"),
             held(strength("transition_width", "i_w", "A", 0.0, 0.0, 20.0,
                           "docs/physics.md#current_dependent_resistance")),
             held(strength("transition_current", "i_s", "A", 0.0, -5.0, 5.0,
                           "docs/physics.md#current_dependent_resistance"))},
            {},
            {"charge_transfer", "current_gain", "second_electrode"},
            "pulses at three amplitudes, looked at after 20 to 100 ms"};
  }
  template <typename S>
  static S voltage(const S* p, const S*, const Instant<S>& instant) {
    using std::tanh;
    const S& i = instant.current;
    S u = S(p[0] * i / (1.0 + magnitudeOf(i) / p[1]));
    if (valueOf(p[2]) > 0.0) {
      const double side = valueOf(i) < 0.0 ? -1.0 : 1.0;
      const S half = S(0.5 * (instant.present.r_charge - instant.present.r_discharge));
      u = S(u + half * (tanh(S((i - p[3]) / p[2])) - side) * i);
    }
    return u;
  }
};

Effect currentDependentResistance() { return effectOf<CurrentDependentResistance>(); }

}  // namespace battery_sof
