#include "effect_definition.hpp"

namespace battery_sof {
namespace {

struct ThresholdGassing {
  static constexpr double kWidth = 0.25;  // [V], docs/physics.md#threshold_gassing

  static EffectInfo info() {
    ParameterInfo threshold{"gassing_threshold", "U_g", "V", 13.8, 13.0, 15.0, "Berndt 1997: docs/physics.md#threshold_gassing"};
    threshold.prior_std = 0.4;
    return {"threshold_gassing",
            "P13",
            "side reactions: a current beyond a threshold of the voltage",
            "C_2 du_c2/dt = i - i_g - i_r2,  i_g = G_g w ln(1 + exp((u_dc + u_c2 - U_g) / w)),  w = 0.25 V",
            {strength("gassing_conductance", "G_g", "S", 0.6, 0.0, 5.0, "paper, Fig. 4: docs/physics.md#threshold_gassing"), threshold},
            {},
            {"gassing", "current_offset", "charge_transfer", "charge_acceptance", "parasitic_load"},
            "constant-voltage plateaus below and above the threshold, 10 min each, and the rest after them",
            {},
            {"u_dc"}};
  }
  template <typename S>
  static S sideCurrent(const S* p, const S& u_c2, const Present<S>& present) {
    using std::exp;
    using std::log;
    const S beyond = S((present.u_dc + u_c2 - p[1]) / kWidth);
    const double z = valueOf(beyond);
    if (z > 40.0) return S(p[0] * kWidth * beyond);
    if (z < -40.0) return S(0.0 * beyond);
    return S(p[0] * kWidth * log(S(1.0 + exp(beyond))));
  }
};

}  // namespace

Effect thresholdGassing() { return effectOf<ThresholdGassing>(); }

}  // namespace battery_sof
