#include "effect_definition.hpp"

namespace battery_sof {
namespace {

// No property of the battery: what charges it. A car's alternator starts at a low voltage after a
// restart and goes to its upper one at a set time; where the battery takes no more than an ampere
// either way, the current does not show it, only the clock does. Told from a memory of the battery
// by the time being the same whatever was drawn and whatever was charged since.
struct SourceDelay {
  static constexpr bool kOnRequest = true;

  static constexpr double kAtOnce = 1.0;     // [s], in which a discharge of i_s sets the clock back
  static constexpr double kLongest = 1.0e5;  // [s], the clock's end, so that it rests somewhere
  static constexpr double kFarAbove =
      1.0e3;  // [1], (i / i_s)^4 beyond it changes nothing that a sample shows

  static EffectInfo info() {
    return {
        "source_delay",
        "I11",
        "the source raises its voltage at a set time after a heavy discharge",
        "dc/dt = 1 - min(((-i)^+ / 20 A)^4, 1000) c / 1 s,  tau_y dy/dt = (-i)^+ - y,  "
        "u += U_s / ((1 + exp((t_s - c) / w)) (1 + y / i_y) (1 + k_s (i)^+))",
        {linearStrength("source_voltage", "U_s", "V", 1.0, 0.0, 3.5,
                        "start-stop recordings; 12 V to the gassing voltage"),
         // Seen: 28 and 46 s.
         shape("source_delay", "t_s", "s", 40.0, 3.0, 600.0, 0.7,
               "start-stop recordings: 28 to 46 s"),
         shape("source_ramp", "w", "s", 6.0, 0.8, 60.0, 0.7, "start-stop recordings: 7 s"),
         // A little discharge lowers the voltage of a charged surface: seen 0.3 A, for 8 s.
         shape("surface_current", "i_y", "A", 1.0, 0.02, 100.0, 1.5,
               "start-stop recordings: 0.3 A"),
         shape("surface_time", "tau_y", "s", 5.0, 1.0, 100.0, 1.0, "start-stop recordings: 8 s"),
         // What the battery takes keeps the source below its voltage: seen 0.05 / A.
         shape("source_yield", "k_s", "1/A", 0.02, 1e-4, 1.0, 1.5,
               "start-stop recordings: 0.05 / A")},
        {{"source_clock", "s", 0.0, 300.0, 0.0, 2000.0}, {"surface_discharge", "A"}},
        {"fresh_sulphate", "charge_acceptance", "ocv_hysteresis", "ocv_soc"},
        "the same restart with the generator off, or a charger of constant voltage",
        {}};
  }
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    const S drawn = positivePart(S(-passage.current));
    const S share = S(drawn / kResetCurrent);
    S back = S(share * share * share * share);
    if (valueOf(back) > kFarAbove) back = S(kFarAbove);
    const S time = S(1.0 / (back / kAtOnce + 1.0 / kLongest));
    x[0] = relaxed(x[0], time, time, passage.duration);
    x[1] = relaxed(x[1], drawn, p[4], passage.duration);
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>& instant) {
    using std::exp;
    const S late = S((p[1] - x[0]) / p[2]);
    if (valueOf(late) > kNotYet) return S(0.0);
    const S yielded = S(1.0 + p[5] * positivePart(instant.current));
    return S(p[0] / ((1.0 + exp(late)) * (1.0 + x[1] / p[3]) * yielded));
  }

 private:
  static constexpr double kResetCurrent =
      20.0;  // [A], a start or the load of a car whose engine stands; seen 17 A
  static constexpr double kNotYet = 50.0;  // [1], where the exponential leaves nothing
};

}  // namespace

Effect sourceDelay() { return effectOf<SourceDelay>(); }

}  // namespace battery_sof
