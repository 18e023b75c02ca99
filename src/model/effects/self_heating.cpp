#include "effect_definition.hpp"

namespace battery_sof {

struct SelfHeating {
  static constexpr bool kStepsFinely = true;
  static constexpr double kLongestPiece = 0.2;       // [s]
  static constexpr double kReference = 298.15;       // [K]
  static constexpr double kGasConstant = 8.314;      // [J/(mol K)]
  static constexpr double kResistanceSlope = 0.006;  // [1/K], docs/physics.md#self_heating

  static EffectInfo info() {
    return {"self_heating",
            "P9",
            "the battery warms itself",
            "C_th dT/dt = i^2 r + (i u_c2)^+ - T / R_th\n"
            "r(T) = r (1 - 0.006 T), I_0(T) = I_0 exp(E_a / R (1/298 K - 1/(298 K + T)))",
            {strength("inverse_heat_capacity", "1/C_th", "K/J", 7.5e-5, 0.0, 5e-4,
                      "docs/physics.md#self_heating"),
             held(shape("thermal_resistance", "R_th", "K/W", 1.0, 0.2, 5.0, 0.7,
                        "docs/physics.md#self_heating")),
             held(shape("activation_energy", "E_a", "J/mol", 5e4, 2e4, 8e4, 0.3,
                        "docs/physics.md#self_heating"))},
            {{"warming", "K"}},
            {"contact_resistance", "parameter_drift"},
            "a temperature sensor at the post",
            {},
            {"r_discharge", "r_charge"}};
  }
  template <typename S>
  static void adapt(const S* p, const S* x, Present<S>& present) {
    using std::exp;
    // Far outside what a battery survives the linear law would turn the resistance negative.
    const S warming = valueOf(x[0]) > 100.0 ? S(100.0) : x[0];
    present.warming = warming;
    const S factor = S(1.0 - kResistanceSlope * warming);
    present.r_discharge = S(present.r_discharge * factor);
    present.r_charge = S(present.r_charge * factor);
    const S inverse = S(1.0 / kReference - 1.0 / (kReference + warming));
    present.i0 = S(present.i0 * exp(S(p[2] / kGasConstant * inverse)));
  }
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    using std::exp;
    const S& i = passage.current;
    const S r = valueOf(i) < 0.0 ? passage.present.r_discharge : passage.present.r_charge;
    const S heat = S(i * i * r + positivePart(S(i * passage.u_c2)));
    // Exact for held heat; the series of (1 - exp(-z)) / z where z = dt / (C_th R_th) is small.
    const S z = S(passage.duration * p[0] / p[1]);
    const S share = valueOf(z) < 1e-3 ? S(1.0 - z * (0.5 - z / 6.0)) : S((1.0 - exp(S(-z))) / z);
    x[0] = S(x[0] + passage.duration * p[0] * (heat - x[0] / p[1]) * share);
  }
};

Effect selfHeating() { return effectOf<SelfHeating>(); }

}  // namespace battery_sof
