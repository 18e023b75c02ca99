#include "effect_definition.hpp"

namespace battery_sof {

struct Gassing {
  // [1/K], docs/physics.md#gassing (Schiffer 2007)
  static constexpr double kTemperatureSlope = 0.06;

  static EffectInfo info() {
    return {
        "gassing",
        "P1",
        "side reactions: gassing and the oxygen cycle",
        "C_2 du_c2/dt = i - i_g - i_r2,  i_g = 1 / (1/i_t + 1/i_O2)\n"
        "i_t = I_g exp(c_u (u_dc + u_c2 - 14.4 V) + 0.06/K T)",
        {strength("gassing_current", "I_g", "A", 0.3, 0.0, 3.0, "docs/physics.md#gassing"),
         shape("gassing_slope", "c_u", "1/V", 1.83, 0.8, 3.0, 0.3,
               "Schiffer 2007: docs/physics.md#gassing"),
         held(shape("oxygen_limit", "i_O2", "A", 3.0, 0.3, 30.0, 0.7, "docs/physics.md#gassing"))},
        {},
        {"current_offset", "charge_transfer", "charge_acceptance", "parasitic_load"},
        "two constant-voltage plateaus at least 0.6 V apart, 10 min each, and the rest after them",
        {},
        {"u_dc"}};
  }
  template <typename S>
  static S sideCurrent(const S* p, const S& u_c2, const Present<S>& present) {
    const S exponent =
        S(p[1] * (present.u_dc + u_c2 - kGassingVoltage) + kTemperatureSlope * present.warming);
    const S tafel = S(p[0] * gassingFactor(exponent));
    return S(tafel * p[2] / (tafel + p[2]));
  }
};

Effect gassing() { return effectOf<Gassing>(); }

}  // namespace battery_sof
