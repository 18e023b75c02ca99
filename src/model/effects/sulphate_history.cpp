#include "effect_definition.hpp"

namespace battery_sof {

struct SulphateHistory {
  static constexpr bool kStepsFinely = true;
  static constexpr double kLongestPiece = 0.2;  // [s]
  static constexpr double kLeast = 0.1;  // [1], smallest share of the limiting current that remains

  static EffectInfo info() {
    return {"sulphate_history",
            "P3",
            "charge acceptance remembers recent discharges",
            "i_lim = i_lim0 A,  dA/dt = [(-i)^+ - chi (i)^+] / Q_A - (A - 1) / tau_r,  A >= 0.1",
            {strength("inverse_history_charge", "1/Q_A", "1/Ah", 1.0, 0.0, 5.0,
                      "docs/physics.md#sulphate_history"),
             shape("history_time", "tau_r", "s", 1200.0, 300.0, 3600.0, 0.7,
                   "docs/physics.md#sulphate_history"),
             shape("history_charge_share", "chi", "1", 0.7, 0.3, 1.0, 0.35,
                   "docs/physics.md#sulphate_history")},
            {{"acceptance", "1", 1.0, 0.2, 0.1, 5.0}},
            {"charge_acceptance"},
            "two equal charges, one right after a discharge of 0.5 Ah, one after 15 min of rest",
            {"charge_acceptance"}};
  }
  template <typename S>
  static void adapt(const S*, const S* x, Present<S>& present) {
    present.acceptance = x[0];
  }
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    const S drawn = positivePart(S(-passage.current));
    const S charged = positivePart(passage.current);
    const S target = S(1.0 + p[1] * p[0] / kSecondsPerHour * (drawn - p[2] * charged));
    x[0] = relaxed(x[0], target, p[1], passage.duration);
    if (valueOf(x[0]) < kLeast) x[0] = S(kLeast);
  }
};

Effect sulphateHistory() { return effectOf<SulphateHistory>(); }

}  // namespace battery_sof
