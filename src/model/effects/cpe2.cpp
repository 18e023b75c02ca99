#include "effect_definition.hpp"

namespace battery_sof {

struct Cpe2 {
  static constexpr bool kIsLadder = true;

  static EffectInfo info() {
    EffectInfo info{"cpe2",
                    "S1",
                    "the double layer is a fractional capacitance",
                    "C_2 w_c^(1-p) d^p u_c2/dt^p in place of C_2 du_c2/dt, w_c = 0.3 rad/s",
                    {strength("dispersion", "1 - p", "1", 0.12, 0.0, 0.4, "docs/physics.md#cpe2")},
                    {},
                    {"second_electrode", "acid_transport", "fast_arc"},
                    "a rest of a minute after a long step: the slope of log|du/dt| against log t"};
    for (int k = 0; k < kLadderRungs; ++k) {
      StateInfo rung{"cpe2_" + std::to_string(k + 1), "V"};
      rung.begins_as_u_c2 = true;
      info.states.push_back(rung);
    }
    return info;
  }
  // The ladder is part of the double layer's step (double_layer.hpp), which reads the exponent
  // here.
  template <typename S>
  static void adapt(const S* p, const S*, Present<S>& present) {
    present.dispersion = p[0];
  }
};

Effect cpe2() { return effectOf<Cpe2>(); }

}  // namespace battery_sof
