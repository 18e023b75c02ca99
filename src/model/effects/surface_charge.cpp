#include "effect_definition.hpp"

namespace battery_sof {

// What a charge leaves at the plates: a voltage that the first part of a discharge takes away, or
// hours of rest.
struct SurfaceCharge {
  static constexpr bool kOnRequest = true;

  static EffectInfo info() {
    return {"surface_charge",
            "P16",
            "a charge leaves a voltage at the plates that the first of a discharge removes",
            "ds/dt = i^+ / Q_s (1 - s) - i^- / Q_s s - s / tau_s,  u += U_s s",
            {linearStrength("surface_voltage", "U_s", "V", 0.1, 0.0, 0.5,
                            "docs/physics.md#surface_charge"),
             shape("surface_capacity", "Q_s", "Ah", 1.0, 0.05, 10.0, 0.8,
                   "docs/physics.md#surface_charge"),
             shape("surface_decay_time", "tau_s", "s", 3e4, 2e3, 3e5, 0.7,
                   "docs/physics.md#surface_charge")},
            {{"surface_charge", "1", 0.0, 0.5, 0.0, 1.0}},
            {"ocv_hysteresis", "acid_transport"},
            "a rest of a night between charge and discharge",
            {"ocv_soc", "acceptance_soc"}};
  }
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    using std::exp;
    const S& i = passage.current;
    const S moving = S(magnitudeOf(i) / (kSecondsPerHour * p[1])), fading = S(1.0 / p[2]);
    const S rate = S(moving + fading);
    const S target = valueOf(i) > 0.0 ? S(moving / rate) : S(0.0);
    const S kept = exp(S(-rate * passage.duration));
    x[0] = S(target + (x[0] - target) * kept);
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>&) {
    return S(p[0] * x[0]);
  }
};

Effect surfaceCharge() { return effectOf<SurfaceCharge>(); }

}  // namespace battery_sof
