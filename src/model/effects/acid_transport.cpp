#include "effect_definition.hpp"

namespace battery_sof {

struct AcidTransport {
  static EffectInfo info() {
    return {"acid_transport",
            "P4",
            "acid diffuses between pores, plates and separator",
            "tau_j dw_j/dt = R_j i - w_j,  u += w_1 + w_2",
            {linearStrength("acid_resistance_1", "R_1", "ohm", 0.002, 0.0, 0.05,
                            "docs/physics.md#acid_transport"),
             shape("acid_time_1", "tau_1", "s", 50.0, 15.0, 150.0, 0.5,
                   "Sulzer 2019, Gu 1997: docs/physics.md#acid_transport"),
             linearStrength("acid_resistance_2", "R_2", "ohm", 0.003, 0.0, 0.2,
                            "docs/physics.md#acid_transport"),
             shape("acid_time_2", "tau_2", "s", 500.0, 150.0, 6000.0, 0.7,
                   "Sulzer 2019, Gu 1997: docs/physics.md#acid_transport")},
            {{"acid_current_1", "A", 0.0, 20.0, -300.0, 300.0},
             {"acid_current_2", "A", 0.0, 10.0, -100.0, 100.0}},
            {"ocv_soc", "ocv_hysteresis", "cpe2", "high_rate_depletion"},
            "a rest of two time constants after 0.5 Ah: acid relaxes, the state of charge stays"};
  }
  // The states are w_j / R_j, so that a vanishing R_j leaves them well defined.
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    x[0] = relaxed(x[0], passage.current, p[1], passage.duration);
    x[1] = relaxed(x[1], passage.current, p[3], passage.duration);
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>&) {
    return S(p[0] * x[0] + p[2] * x[1]);
  }
};

Effect acidTransport() { return effectOf<AcidTransport>(); }

}  // namespace battery_sof
