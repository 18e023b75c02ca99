#include "effect_definition.hpp"

namespace battery_sof {

struct CoupDeFouet {
  static EffectInfo info() {
    return {"coup_de_fouet",
            "P8",
            "the dip at the first discharge after a full charge",
            "u -= U_cf (1 - n) (1 - z)\n"
            "dn/dt = (-i)^+ (1 - n) / Q_n - (i)^+ n / Q_e,  dz/dt = -(-i)^+ z / Q_r + (i)^+ (1 - "
            "z) / Q_r",
            {linearStrength("coup_voltage", "U_cf", "V", 0.1, 0.0, 0.3,
                            "Rys 2021: docs/physics.md#coup_de_fouet"),
             shape("coup_charge", "Q_n", "Ah", 0.3, 0.1, 1.0, 0.5, "docs/physics.md#coup_de_fouet"),
             held(shape("coup_onset_charge", "Q_r", "Ah", 0.02, 0.005, 0.1, 0.5,
                        "docs/physics.md#coup_de_fouet")),
             held(shape("coup_recharge", "Q_e", "Ah", 1.0, 0.1, 10.0, 0.7,
                        "docs/physics.md#coup_de_fouet"))},
            {{"nucleation", "1"}, {"coup_onset", "1", 1.0}},
            {"acid_transport", "high_rate_depletion"},
            "a discharge after a full charge: only this dip recovers while the current flows"};
  }
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    using std::exp;
    const double ah = passage.duration / kSecondsPerHour;
    const S drawn = S(positivePart(S(-passage.current)) * ah);
    const S charged = S(positivePart(passage.current) * ah);
    x[0] = S((1.0 - (1.0 - x[0]) * exp(S(-drawn / p[1]))) * exp(S(-charged / p[3])));
    x[1] = S(1.0 - (1.0 - x[1] * exp(S(-drawn / p[2]))) * exp(S(-charged / p[2])));
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>&) {
    return S(-p[0] * (1.0 - x[0]) * (1.0 - x[1]));
  }
};

Effect coupDeFouet() { return effectOf<CoupDeFouet>(); }

}  // namespace battery_sof
