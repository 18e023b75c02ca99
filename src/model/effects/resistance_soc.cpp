#include "effect_definition.hpp"

namespace battery_sof {

struct ResistanceSoc {
  static constexpr bool kStepsFinely = true;  // self-heating by it

  static EffectInfo info() {
    return {"resistance_soc",
            "P14",
            "the resistance rises as the battery is discharged",
            "dq/dt = i,  r(q) = r exp(-rho k_s q)",
            {strength("resistance_rise", "rho", "1/V", 1.0, 0.0, 4.0,
                      "docs/physics.md#resistance_soc")},
            {{"drawn_charge", "Ah"}},
            {"parameter_drift", "end_of_discharge", "acid_transport"},
            "the same pulse of current at two states of charge",
            {"ocv_soc"},
            {"ocv_slope"}};
  }
  template <typename S>
  static void adapt(const S* p, const S* x, Present<S>& present) {
    using std::exp;
    const S rise = exp(S(-p[0] * present.ocv_slope * x[0]));
    present.r_discharge = S(present.r_discharge * rise);
    present.r_charge = S(present.r_charge * rise);
  }
  template <typename S>
  static void advance(const S*, S* x, const Passage<S>& passage) {
    x[0] = S(x[0] + passage.current * (passage.duration / kSecondsPerHour));
  }
};

Effect resistanceSoc() { return effectOf<ResistanceSoc>(); }

}  // namespace battery_sof
