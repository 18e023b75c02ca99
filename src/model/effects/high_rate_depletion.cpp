#include "effect_definition.hpp"

namespace battery_sof {

struct HighRateDepletion {
  // Where the acid in the pores is used up the logarithm ends; a linear continuation keeps the
  // voltage finite.
  static constexpr double kMinLeft = 0.02;

  static EffectInfo info() {
    return {"high_rate_depletion",
            "P7",
            "acid in the pores is used up during heavy discharges",
            "tau dx/dt = (-i)^+ / i_L - x,  u += kappa ln(1 - x)",
            {strength("inverse_depletion_current", "1/i_L", "1/A", 1.0 / 400.0, 0.0, 1.0 / 300.0,
                      "docs/physics.md#high_rate_depletion"),
             shape("depletion_time", "tau", "s", 25.0, 10.0, 60.0, 0.4,
                   "docs/physics.md#high_rate_depletion"),
             held(shape("depletion_voltage", "kappa", "V", 0.15, 0.1, 0.25, 0.3,
                        "docs/physics.md#high_rate_depletion"))},
            {{"drawn_current", "A"}},
            {"acid_transport", "cpe2"},
            "a crank after 1 s and one after 60 s of -100 A"};
  }
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    x[0] = relaxed(x[0], positivePart(S(-passage.current)), p[1], passage.duration);
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>&) {
    using std::log;
    const S left = S(1.0 - p[0] * x[0]);
    if (valueOf(left) > kMinLeft) return S(p[2] * log(left));
    return S(p[2] * (std::log(kMinLeft) + left / kMinLeft - 1.0));
  }
};

Effect highRateDepletion() { return effectOf<HighRateDepletion>(); }

}  // namespace battery_sof
