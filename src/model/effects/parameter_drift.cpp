#include <cmath>

#include "effect_definition.hpp"

namespace battery_sof {

struct ParameterDrift {
  static constexpr bool kStepsFinely = true;
  static constexpr double kLongestPiece = 0.5;  // [s]
  // [h], heat capacity times thermal resistance of a battery (docs/physics.md#self_heating): what
  // drifts for longer was not its temperature, and e^(d t) has no end.
  static constexpr double kSettling = 4.0;

  static EffectInfo info() {
    return {
        "parameter_drift",
        "P10",
        "the parameters themselves drift",
        "r(t) = r exp(d_r s), C_2(t) = C_2 exp(d_c s), beta(t) = beta exp(d_b s)\n"
        "s = tau_d (1 - exp(-t / tau_d)), tau_d = 4 h",
        {strength("resistance_drift", "d_r", "1/h", 0.1, -2.0, 2.0,
                  "docs/physics.md#parameter_drift"),
         strength("c2_drift", "d_c", "1/h", 0.1, -2.0, 2.0, "docs/physics.md#parameter_drift"),
         strength("beta_drift", "d_b", "1/h", 0.1, -2.0, 2.0, "docs/physics.md#parameter_drift")},
        {},
        {"self_heating", "contact_resistance"},
        "a second recording of the same regime an hour later"};
  }
  template <typename S>
  static void adapt(const S* p, const S*, Present<S>& present) {
    using std::exp;
    const double hours = -kSettling * std::expm1(-present.time / (kSecondsPerHour * kSettling));
    const S resistance = exp(S(p[0] * hours));
    present.r_discharge = S(present.r_discharge * resistance);
    present.r_charge = S(present.r_charge * resistance);
    present.c2 = S(present.c2 * exp(S(p[1] * hours)));
    present.beta = S(present.beta * exp(S(p[2] * hours)));
  }
};

Effect parameterDrift() { return effectOf<ParameterDrift>(); }

}  // namespace battery_sof
