#include "effect_definition.hpp"

namespace battery_sof {

// The end of a charge. What is left of the sulphate dissolves more and more slowly, so that the
// current under a held voltage fades as the battery fills, and a current that is forced on it
// drives the voltage up to where gassing takes it.
struct AcceptanceSoc {
  static constexpr bool kLimitsReaction = true;
  // A current that is forced past what the sulphate accepts says nothing but that it was.
  static constexpr bool kOnRequest = true;
  static constexpr double kLongestPiece = 10.0;  // [s]
  static constexpr double kLeast = 0.01;         // [Ah], so that a full battery leaves a slope

  static EffectInfo info() {
    return {"acceptance_soc",
            "P15",
            "the battery accepts less charge as it fills",
            "i_r2 = I_0 exp(alpha beta u) / (1 + I_0 exp(alpha beta u) / L) - I_0 exp((alpha - 1) "
            "beta u)\n"
            "L = S^2 / K,  dS/dt = -i_r2,  i_f = I_f exp(1.83/V (u_dc + u_c2 - 14.4 V))\n"
            "C_2 du_c2/dt = i - i_r2 - i_f,  dG/dt = i_f,  u -= k_s G",
            {strength("acceptance_fall", "K", "Ah^2/A", 5.0, 0.0, 500.0,
                      "docs/physics.md#acceptance_soc"),
             strength("overcharge_current", "I_f", "A", 0.1, 0.0, 3.0,
                      "docs/physics.md#acceptance_soc")},
            {{"sulphate_left", "Ah", 20.0, 50.0, 0.1, 1000.0}, {"overcharge", "Ah"}},
            {"charge_acceptance", "fresh_sulphate", "gassing"},
            "a charge at a held voltage until the current stays",
            {"ocv_soc"},
            {"ocv_slope", "u_dc"}};
  }
  template <typename S>
  static void adapt(const S* p, const S* x, Present<S>& present) {
    const S left = S(positivePart(x[0]) + kLeast);
    present.inverse_supply = S(present.inverse_supply + p[0] / (left * left));
  }
  template <typename S>
  static S sideCurrent(const S* p, const S& u_c2, const Present<S>& present) {
    return S(p[1] * gassingFactor(u_c2, present));
  }
  // Implicit in S while charging, so that it never falls below zero.
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    const double hours = passage.duration / kSecondsPerHour;
    const S left = S(positivePart(x[0]) + kLeast);
    const S gained = S(hours * positivePart(S(-passage.reaction)));
    const S taken = S(hours * positivePart(passage.reaction));
    x[0] = S((left + gained) / (1.0 + taken / left) - kLeast);
    x[1] = S(x[1] + hours * sideCurrent(p, passage.u_c2, passage.present));
  }
  // What ocv_soc counts, though it is not charge.
  template <typename S>
  static S voltage(const S*, const S* x, const Instant<S>& instant) {
    return S(-instant.present.ocv_slope * x[1]);
  }
};

Effect acceptanceSoc() { return effectOf<AcceptanceSoc>(); }

}  // namespace battery_sof
