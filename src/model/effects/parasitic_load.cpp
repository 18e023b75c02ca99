#include "effect_definition.hpp"

namespace battery_sof {

struct ParasiticLoad {
  static EffectInfo info() {
    return {"parasitic_load",
            "P11",
            "a load or self-discharge that the sensor does not see",
            "i = i_measured + i_p",
            {strength("parasitic_current", "i_p", "A", -0.1, -0.3, 0.0,
                      "docs/physics.md#parasitic_load")},
            {},
            {"current_offset", "gassing"},
            "nothing in current and voltage: it is an offset of the current",
            {},
            {},
            {"current_offset"}};
  }
  template <typename S>
  static void sense(const S* p, const InputStep& step, S& mean, S& end) {
    if (step.gap) return;
    mean = S(mean + p[0]);
    end = S(end + p[0]);
  }
};

Effect parasiticLoad() { return effectOf<ParasiticLoad>(); }

}  // namespace battery_sof
