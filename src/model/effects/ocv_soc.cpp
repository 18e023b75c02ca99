#include "effect_definition.hpp"

namespace battery_sof {

struct OcvSoc {
  static constexpr bool kAdaptsForOthers = true;

  static EffectInfo info() {
    return {
        "ocv_soc",
        "P5",
        "the open-circuit voltage moves with the state of charge",
        "dq/dt = i,  u += k_s q",
        {linearStrength("ocv_slope", "k_s", "V/Ah", 0.027, 0.0, 0.3, "docs/physics.md#ocv_soc")},
        {{"charge", "Ah"}},
        {"acid_transport", "ocv_hysteresis", "voltage_drift"},
        "a rest of an hour after 0.5 Ah: what stays is the state of charge"};
  }
  template <typename S>
  static void adapt(const S* p, const S*, Present<S>& present) {
    present.ocv_slope = p[0];
  }
  template <typename S>
  static void advance(const S*, S* x, const Passage<S>& passage) {
    x[0] = S(x[0] + passage.current * (passage.duration / kSecondsPerHour));
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>&) {
    return S(p[0] * x[0]);
  }
};

Effect ocvSoc() { return effectOf<OcvSoc>(); }

}  // namespace battery_sof
