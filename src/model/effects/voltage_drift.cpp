#include "effect_definition.hpp"

namespace battery_sof {

struct VoltageDrift {
  static EffectInfo info() {
    return {"voltage_drift",
            "I9",
            "the voltage channel drifts",
            "u_shown = u + d_1 t; a constant offset leaves no trace",
            {linearStrength("voltage_drift", "d_1", "V/h", 0.01, -0.2, 0.2,
                            "docs/physics.md#voltage_drift")},
            {},
            {"ocv_soc", "acid_transport"},
            "a reference voltage on the same channel"};
  }
  template <typename S>
  static void show(const S* p, S*, const Instant<S>& instant, S& voltage) {
    voltage = S(voltage + p[0] * (instant.present.time / kSecondsPerHour));
  }
};

Effect voltageDrift() { return effectOf<VoltageDrift>(); }

}  // namespace battery_sof
