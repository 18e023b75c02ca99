#include "effect_definition.hpp"

namespace battery_sof {
namespace {

// What a discharge has just turned into sulphate dissolves easily, is recharged near the open-circuit voltage and holds the
// voltage down. As it ages (or is used up), charging meets a blocked electrode, whose voltage the source and the side reactions
// set: from the same current a voltage higher by up to U_f. A little discharge ends that within seconds.
//
// An effective law, read off start-stop cars at 1 Hz. Ageing goes with time alone, not with the charge taken (a term for it
// vanished in every fit), so the law holds while a source charges: a rest without any current is outside what it was seen in.
struct FreshSulphate {
  static EffectInfo info() {
    return {"fresh_sulphate",
            "P12",
            "charging is easy while what was just discharged is still fresh",
            "ds/dt = (-i)^+ + k_f (i)^+ - s / tau_f,  u += U_f s_f / (s_f + s)",
            // Up to the gassing voltage of an aged block, 15.5 V, from a discharged one's 12 V. Seen: 1.1 to 1.8 V.
            {linearStrength("blocked_voltage", "U_f", "V", 1.0, 0.0, 3.5,
                            "start-stop recordings; 12 V to the gassing voltage"),
             // Seen: 0.8 to 12 As. Below, a sample's noise makes it; above, it is charge acceptance of minutes (P3).
             shape("fresh_charge", "s_f", "As", 5.0, 0.1, 500.0, 1.5,
                   "start-stop recordings: 1 to 12 As for 72 Ah"),
             // Seen: 6 to 15 s. From two samples at 1 Hz to where P3 begins.
             shape("fresh_time", "tau_f", "s", 12.0, 2.0, 300.0, 1.0,
                   "start-stop recordings: 6 to 15 s at 45 to 65 degC"),
             // What a charging current that flows says of the electrode: it is not blocked yet. Seen: 0.001 to 0.1.
             shape("fresh_charging_share", "k_f", "1", 0.01, 1e-4, 0.5, 1.5,
                   "start-stop recordings: 0.001 to 0.1")},
            // 0 to what several cranks leave. After a long rest nothing is blocked: as much as that.
            {{"fresh_sulphate", "As", 2000.0, 1000.0, 0.0, 2000.0}},
            {"charge_acceptance", "sulphate_history", "ocv_hysteresis", "ocv_soc", "acid_transport"},
            "charge at a low held voltage, once right after a discharge and once 2 min after it",
            {}};
  }
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    const S drawn = positivePart(S(-passage.current));
    const S charged = positivePart(passage.current);
    x[0] = relaxed(x[0], S((drawn + p[3] * charged) * p[2]), p[2], passage.duration);
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>&) {
    return S(p[0] * p[1] / (p[1] + x[0]));
  }
};

}  // namespace

Effect freshSulphate() { return effectOf<FreshSulphate>(); }

}  // namespace battery_sof
