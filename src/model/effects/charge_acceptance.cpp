#include "effect_definition.hpp"

namespace battery_sof {

struct ChargeAcceptance {
  static EffectInfo info() {
    return {"charge_acceptance",
            "P2",
            "lead ions deplete while charging and are slowly refilled",
            "i_r2 = I_0 { p exp(alpha beta u) - exp((alpha - 1) beta u) }\n"
            "dp/dt = (1 - p) / tau_d - i_r2 / (i_lim tau_d)",
            {strength("inverse_limiting_current", "1/i_lim", "1/A", 1.0 / 60.0, 0.0, 0.2,
                      "docs/physics.md#charge_acceptance"),
             shape("refill_time", "tau_d", "s", 12.0, 1.0, 600.0, 0.8,
                   "docs/physics.md#charge_acceptance")},
            {{"log_activity", "1", 0.0, 0.5, -5.0, 2.0}},
            {"acid_transport", "charge_transfer", "sulphate_history", "ocv_hysteresis"},
            "a discharge of the same size and length as the charge: acid reacts to it, lead ions "
            "do not"};
  }
  /// Linear in p for a given u, positive for every step.
  template <typename S>
  static S activity(const S* p, const S& before, const ReactionRates<S>& rates,
                    const Present<S>& present, double duration) {
    const S k = S(duration / p[1]);
    const S inverse_limit = S(p[0] / present.acceptance);
    return S((before + k * (1.0 + rates.discharging * inverse_limit)) /
             (1.0 + k * (1.0 + rates.charging * inverse_limit)));
  }
};

Effect chargeAcceptance() { return effectOf<ChargeAcceptance>(); }

}  // namespace battery_sof
