#include "effect_definition.hpp"

namespace battery_sof {

struct ChargeTransfer {
  static EffectInfo info() {
    ParameterInfo exchange = shape("exchange_current", "I_0", "A", 1.0, 0.2, 5.0, 0.3,
                                   "docs/physics.md#charge_transfer");
    exchange.vanishes_at = 1.0;
    ParameterInfo symmetry{
        "transfer_symmetry", "alpha", "1", 0.5, 0.3, 0.7, "docs/physics.md#charge_transfer"};
    symmetry.prior_std = 0.05;
    symmetry.vanishes_at = 0.5;
    return {"charge_transfer",
            "S4",
            "kinetics other than I_0 = 1 A and alpha = 0.5",
            "i_r2 = I_0 { exp(alpha beta u) - exp((alpha - 1) beta u) }",
            {exchange, symmetry},
            {},
            {"current_offset", "gassing", "charge_acceptance"},
            "the asymmetry of charge and discharge has no history"};
  }
  template <typename S>
  static void adapt(const S* p, const S*, Present<S>& present) {
    present.i0 = p[0];
    present.alpha = p[1];
  }
};

Effect chargeTransfer() { return effectOf<ChargeTransfer>(); }

}  // namespace battery_sof
