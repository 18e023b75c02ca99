#include "effect_definition.hpp"

namespace battery_sof {

struct CurrentGain {
  static EffectInfo info() {
    return {
        "current_gain",
        "I2",
        "the current sensor's gain is wrong",
        "i = i_measured / (1 + g + sign(i) a / 2); g, alike in both directions, leaves no trace in "
        "current and voltage",
        {strength("gain_asymmetry", "a", "1", 0.02, -0.1, 0.1, "docs/physics.md#current_gain"),
         held(strength("gain_error", "g", "1", 0.0, -0.1, 0.1, "docs/physics.md#current_gain"))},
        {},
        {"charge_transfer", "current_dependent_resistance"},
        "a second current sensor, or a known charge"};
  }
  template <typename S>
  static S corrected(const S* p, const S& current) {
    const double side = valueOf(current) < 0.0 ? -0.5 : 0.5;
    return S(current / (1.0 + p[1] + side * p[0]));
  }
  template <typename S>
  static void sense(const S* p, const InputStep&, S& mean, S& end) {
    mean = corrected(p, mean);
    end = corrected(p, end);
  }
};

Effect currentGain() { return effectOf<CurrentGain>(); }

}  // namespace battery_sof
