#include "effect_definition.hpp"

namespace battery_sof {

// Charge acceptance by charge balance. What a discharge has just turned into sulphate dissolves
// easily and can be charged back at once; without it the reaction is fed by a small current alone
// and the electrode is blocked. A slow relaxation in the pores goes with it. One resistance serves
// both signs: r_charge replaces this physics and is not used with it.
struct FreshSulphate {
  static constexpr bool kLimitsReaction = true;
  // From the current alone the law is ill-posed: it is fitted where the voltage is the input.
  static constexpr bool kOnRequest = true;
  // [s]; the supply stays as it is over a piece. Half of it changes a crank's minimum at 1 Hz by
  // less than 1 mV.
  static constexpr double kLongestPiece = 0.5;
  // What a blocked electrode does with a current that is forced on it: gassing
  // (docs/physics.md#fresh_sulphate). Below 14.4 V it is a few hundredths of an ampere. [A]
  static constexpr double kGassing = 0.03;
  static constexpr double kLeast = 1e-3;  // [As], so that an emptied reservoir leaves a slope

  static EffectInfo info() {
    ParameterInfo present = held(strength("fresh_sulphate_share", "z", "1", 1.0, 0.0, 1.0,
                                          "docs/physics.md#fresh_sulphate; 0: the base model, 1: "
                                          "the law, between them a path for a search"));
    return {
        "fresh_sulphate",
        "P12",
        "charge is accepted while what was just discharged is still fresh",
        "i_r2 = I_0 { g exp(alpha beta u) - exp((alpha - 1) beta u) } / (1 + I_0 g exp(alpha beta "
        "u) / L)\n"
        "g = sqrt(S / S_q),  L = L_0 + S / tau_s\n"
        "dS/dt = kappa (-i_r2)^+ - (i_r2)^+ (S / tau_s) / L\n"
        "tau_w dw/dt = R_w i - w,  u += w,  r_charge = r_discharge\n"
        "C_2 du_c2/dt = i - i_r2 - z 0.03 A exp(1.83/V (u_dc + u_c2 - 14.4 V))",
        {present,
         shape("fresh_exchange_current", "I_0", "A", 2.0, 0.01, 50.0, 0.7,
               "start-stop recordings: 0.9 to 5.6 A"),
         shape("steady_supply", "L_0", "A", 0.5, 0.01, 30.0, 1.0,
               "start-stop recordings: 0.23 to 3 A"),
         shape("dissolution_time", "tau_s", "s", 4.0, 0.3, 3000.0, 1.1,
               "start-stop recordings: 1.4 to 25 s"),
         shape("recharged_share", "kappa", "1", 0.9, 0.02, 3.0, 0.2,
               "start-stop recordings: 0.54 to 0.9"),
         shape("sulphate_scale", "S_q", "As", 20.0, 1.0, 5000.0, 0.55,
               "start-stop recordings: 11 to 45 As"),
         shape("pore_resistance", "R_w", "ohm", 0.007, 1e-4, 0.1, 0.46,
               "start-stop recordings: 4 to 13 mOhm"),
         shape("pore_time", "tau_w", "s", 15.0, 3.0, 3000.0, 0.7,
               "start-stop recordings: 6 to 35 s")},
        // A rested electrode has been recharged through and its sulphate has grown coarse.
        {{"fresh_sulphate", "As", 50.0, 150.0, 1.0, 20000.0},
         {"pore_current", "A", 0.0, 10.0, -300.0, 300.0}},
        {"charge_acceptance", "sulphate_history", "ocv_hysteresis", "ocv_soc", "acid_transport"},
        "charge at a held voltage after discharges of two sizes: what goes in follows what came "
        "out",
        {},
        {"r_discharge", "r_charge", "u_dc"},
        {},
        {shape("r_discharge", "r_-", "ohm", 0.006, 0.0005, 0.2, 0.5,
               "start-stop recordings: 2 to 8 mOhm"),
         held(shape("r_charge", "r_+", "ohm", 0.006, 0.0005, 0.2, 0.5, "equal to r_-")),
         // The fast part of the double layer alone: what is slow stands in w and S.
         shape("c2", "C_2", "F", 5.0, 1.0, 5000.0, 0.5, "start-stop recordings: 3 to 10 F"),
         shape("beta", "beta", "1/V", 35.0, 1.0, 300.0, 0.36,
               "start-stop recordings: 22 to 56 1/V")}};
  }
  template <typename S>
  static void adapt(const S* p, const S* x, Present<S>& present) {
    using std::exp;
    using std::log;
    using std::sqrt;
    const S& z = p[0];
    const S stock = S(positivePart(x[0]) + kLeast);
    present.i0 = S(present.i0 * exp(S(z * log(p[1]))));
    present.r_charge = S(present.r_charge + z * (present.r_discharge - present.r_charge));
    present.reactivity = S(1.0 + z * (sqrt(S(stock / p[5])) - 1.0));
    present.inverse_supply = S(z * p[3] / (p[2] * p[3] + stock));
  }
  template <typename S>
  static S sideCurrent(const S* p, const S& u_c2, const Present<S>& present) {
    return S(p[0] * kGassing * gassingFactor(u_c2, present));
  }
  // Of what reacts while charging the share (S / tau_s) / L comes out of the reservoir: S / (L_0
  // tau_s + S) of it, implicit in S, so that it never falls below zero.
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    const S gained = S(passage.duration * p[4] * positivePart(S(-passage.reaction)));
    const S taken = S(passage.duration * positivePart(passage.reaction));
    const S stock = positivePart(x[0]);
    x[0] = S((stock + gained) / (1.0 + taken / (p[2] * p[3] + stock + kLeast)));
    x[1] = relaxed(x[1], passage.current, p[7], passage.duration);
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>&) {
    return S(p[0] * p[6] * x[1]);
  }
};

Effect freshSulphate() { return effectOf<FreshSulphate>(); }

}  // namespace battery_sof
