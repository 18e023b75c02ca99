#include "effect_definition.hpp"

namespace battery_sof {

struct OcvHysteresis {
  static EffectInfo info() {
    return {"ocv_hysteresis",
            "P6",
            "the open-circuit voltage depends on the direction of the last charge",
            "dh/dt = |i| / Q_h (sign(i) - h),  u += M h",
            {linearStrength("hysteresis_voltage", "M", "V", 0.02, 0.0, 0.1,
                            "docs/physics.md#ocv_hysteresis"),
             shape("hysteresis_charge", "Q_h", "Ah", 0.2, 0.05, 1.0, 0.5,
                   "docs/physics.md#ocv_hysteresis")},
            {{"hysteresis", "1", 0.0, 0.5, -1.0, 1.0}},
            {"acid_transport", "ocv_soc"},
            "one cycle again at half the current: hysteresis follows the charge, acid the time"};
  }
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    using std::exp;
    const S& i = passage.current;
    const double side = valueOf(i) < 0.0 ? -1.0 : 1.0;
    const S kept = exp(S(-magnitudeOf(i) * (passage.duration / kSecondsPerHour) / p[1]));
    x[0] = S(side + (x[0] - side) * kept);
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>&) {
    return S(p[0] * x[0]);
  }
};

Effect ocvHysteresis() { return effectOf<OcvHysteresis>(); }

}  // namespace battery_sof
