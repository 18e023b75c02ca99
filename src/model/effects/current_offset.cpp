#include "effect_definition.hpp"

namespace battery_sof {

struct CurrentOffset {
  static EffectInfo info() {
    return {
        "current_offset",
        "I1",
        "the current sensor reads an offset",
        "i = i_measured - i_o",
        {strength("current_offset", "i_o", "A", 0.5, -5.0, 5.0, "docs/physics.md#current_offset")},
        {},
        {"gassing", "charge_transfer", "parasitic_load"},
        "the reading with the battery disconnected",
        {},
        {},
        {"parasitic_load"}};
  }
  template <typename S>
  static void sense(const S* p, const InputStep& step, S& mean, S& end) {
    if (step.gap) return;
    mean = S(mean - p[0]);
    end = S(end - p[0]);
  }
};

Effect currentOffset() { return effectOf<CurrentOffset>(); }

}  // namespace battery_sof
