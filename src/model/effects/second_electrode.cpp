#include "effect_definition.hpp"

namespace battery_sof {

struct SecondElectrode {
  static EffectInfo info() {
    return {"second_electrode",
            "S5",
            "the other electrode has a double layer and a slope of its own",
            "C_3 du_3/dt = i - 2 I_03 sinh(u_3 / (2 B_3)),  C_3 = tau_3 I_03 / B_3,  u += u_3",
            // With the time constant in place of C_3 the voltage is linear in B_3.
            {linearStrength("b3", "B_3", "V", 0.02, 0.0, 0.1, "docs/physics.md#second_electrode"),
             shape("electrode_time_3", "tau_3", "s", 40.0, 0.5, 10000.0, 2.0,
                   "docs/physics.md#second_electrode: 300 to 6000 F at 5 to 40 mV; from 100 F, "
                   "what is faster is fast_arc"),
             held(shape("exchange_current_3", "I_03", "A", 1.0, 0.2, 5.0, 0.3,
                        "docs/physics.md#second_electrode"))},
            {{"u_3_over_b3", "1", 0.0, 1.0, -15.0, 15.0}},
            {"cpe2", "acid_transport"},
            "a rest of a minute after a long step: one knee or two"};
  }
  // The state is u_3 / B_3: tau_3 dx/dt = i / I_03 - 2 sinh(x / 2), well defined where B_3
  // vanishes.
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    x[0] =
        closedFormAdvance(x[0], passage.current, p[2], S(passage.duration / (2.0 * p[1] * p[2])));
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>&) {
    return S(p[0] * x[0]);
  }
};

Effect secondElectrode() { return effectOf<SecondElectrode>(); }

}  // namespace battery_sof
