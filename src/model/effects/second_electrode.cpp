#include "effect_definition.hpp"

namespace battery_sof {
namespace {

struct SecondElectrode {
  static EffectInfo info() {
    return {"second_electrode",
            "S5",
            "the other electrode has a double layer and a slope of its own",
            "C_3 du_3/dt = i - 2 I_03 sinh(u_3 / (2 B_3)),  u += u_3",
            {strength("b3", "B_3", "V", 0.02, 0.0, 0.1, "PHYSICS 1.1"),
             shape("c3", "C_3", "F", 2000.0, 100.0, 1e5, 1.0, "PHYSICS 1.1"),
             held(shape("exchange_current_3", "I_03", "A", 1.0, 0.2, 5.0, 0.3, "PHYSICS 1.1"))},
            {{"u_3_over_b3", "1", 0.0, 1.0, -15.0, 15.0}},
            {"cpe2", "acid_transport"},
            "a rest of a minute after a long step: one knee or two",
            {}};
  }
  // The state is u_3 / B_3, so that a vanishing B_3 leaves it well defined.
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    const double slowness = valueOf(p[0]) * valueOf(p[1]);
    const S half_rate = slowness > 0.0 ? S(passage.duration / (2.0 * p[0] * p[1])) : S(1e6);
    x[0] = closedFormAdvance(x[0], passage.current, p[2], half_rate);
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>&) {
    return S(p[0] * x[0]);
  }
};

}  // namespace

Effect secondElectrode() { return effectOf<SecondElectrode>(); }

}  // namespace battery_sof
