#include "effect_definition.hpp"

namespace battery_sof {

struct EndOfDischarge {
  // x / kappa below which the logarithm goes on as a straight line, so that the voltage stays finite.
  static constexpr double kLeast = 0.1;
  static constexpr double kNoWidth = 1e-3;  // [V]

  static EffectInfo info() {
    ParameterInfo width = strength("exhaustion_width", "kappa", "V", 0.4, 0.0, 1.5,
                                   "docs/physics.md#end_of_discharge");
    width.prior_std = 0.2;
    ParameterInfo voltage{
        "exhaustion_voltage", "U_E", "V", 11.75, 11.0, 12.3, "docs/physics.md#end_of_discharge"};
    voltage.prior_std = 0.2;
    return {"end_of_discharge",
            "P13",
            "the acid is used up: the voltage falls steeply at the end of a discharge",
            "dq/dt = i,  tau_E dw/dt = i - w,  x = u_dc + k_s (q + theta w) - U_E\n"
            "u += f(x) - f(u_dc - U_E),  f(x) = kappa ln(1 - exp(-x / kappa))",
            {width, voltage,
             shape("pore_delay", "theta", "s", 1000.0, 100.0, 50000.0, 0.8,
                   "docs/physics.md#end_of_discharge"),
             shape("pore_refill_time", "tau_E", "s", 700.0, 100.0, 4000.0, 0.4,
                   "docs/physics.md#end_of_discharge")},
            {{"moved_charge", "Ah"}, {"pore_load", "A"}},
            {"high_rate_depletion", "acid_transport", "parameter_drift"},
            "the rest after it: what acid transport took comes back, what was drawn does not",
            {"ocv_soc"},
            {"ocv_slope", "u_dc"},
            {},
            // A discharge of one load shows the sum of their voltages alone.
            {shape("r_discharge", "r_-", "ohm", 0.008, 0.001, 0.1, 1.0, "docs/model.md"),
             shape("c2", "C_2", "F", 1000.0, 100.0, 5000.0, 1.0, "docs/model.md"),
             shape("beta", "beta", "1/V", 20.0, 1.0, 1000.0, 0.5, "docs/model.md")}};
  }
  template <typename S>
  static void advance(const S* p, S* x, const Passage<S>& passage) {
    x[0] = S(x[0] + passage.current * (passage.duration / kSecondsPerHour));
    x[1] = relaxed(x[1], passage.current, p[3], passage.duration);
  }
  template <typename S>
  static S voltage(const S* p, const S* x, const Instant<S>& instant) {
    const Present<S>& now = instant.present;
    const S first = S(now.u_dc - p[1]);
    const S in_pores = S(x[0] + p[2] / kSecondsPerHour * x[1]);
    return S(bend(S(first + now.ocv_slope * in_pores), p[0]) - bend(first, p[0]));
  }

 private:
  /// What a voltage above U_E loses. @param width kappa [V].
  template <typename S>
  static S bend(const S& above, const S& width) {
    using std::exp;
    using std::log;
    if (valueOf(width) < kNoWidth) return S(0.0);
    const S left = S(above / width);
    if (valueOf(left) < kLeast)
      return S(width * (std::log(-std::expm1(-kLeast)) + (left - kLeast) / std::expm1(kLeast)));
    return S(width * log(S(1.0 - exp(S(-left)))));
  }
};

Effect endOfDischarge() { return effectOf<EndOfDischarge>(); }

}  // namespace battery_sof
