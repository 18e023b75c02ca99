#include "effect_definition.hpp"

namespace battery_sof {

struct ContactResistance {
  static constexpr double kWidth = 1.0;  // [s], of the step, so that its time has a derivative

  static EffectInfo info() {
    ParameterInfo when{
        "contact_time", "t_c", "s", 600.0, 0.0, 1e6, "docs/physics.md#contact_resistance"};
    when.instant = true;
    return {
        "contact_resistance",
        "I6",
        "the resistance of a cable or contact has changed",
        "u += r_c / 2 (1 + tanh((t - t_c) / 1 s)) i; a constant contact resistance leaves no trace",
        {linearStrength("contact_step", "r_c", "ohm", 0.0005, -0.005, 0.02,
                        "docs/physics.md#contact_resistance"),
         when},
        {},
        {"self_heating", "parameter_drift"},
        "the voltage at the battery's posts"};
  }
  template <typename S>
  static S voltage(const S* p, const S*, const Instant<S>& instant) {
    using std::tanh;
    const S on = S(0.5 * (1.0 + tanh(S((instant.present.time - p[1]) / kWidth))));
    return S(p[0] * on * instant.current);
  }
};

Effect contactResistance() { return effectOf<ContactResistance>(); }

}  // namespace battery_sof
