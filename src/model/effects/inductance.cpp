#include "effect_definition.hpp"

namespace battery_sof {

struct Inductance {
  static constexpr bool kActsAtEdges = true;

  static EffectInfo info() {
    return {"inductance",
            "S6",
            "inductance of battery and wiring",
            "u += L di/dt",
            {linearStrength("inductance", "L", "H", 1e-6, 0.0, 5e-6, "docs/physics.md#inductance")},
            {},
            {"time_skew"},
            "nothing at 100 Hz: its trace is that of a shift between the channels",
            {},
            {},
            {"time_skew"}};
  }
  template <typename S>
  static S voltage(const S* p, const S*, const Instant<S>& instant) {
    return S(p[0] * instant.slope);
  }
};

Effect inductance() { return effectOf<Inductance>(); }

}  // namespace battery_sof
