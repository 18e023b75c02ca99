#include "effect_definition.hpp"

namespace battery_sof {

struct SensorLag {
  static constexpr bool kActsAtEdges = true;

  static EffectInfo info() {
    return {"sensor_lag",
            "I4",
            "one channel lags behind the other",
            "tau > 0: tau du_shown/dt = u - u_shown\n"
            "tau < 0: i = i_measured + |tau| di_measured/dt",
            {strength("channel_lag", "tau", "s", 0.02, -0.1, 0.1, "docs/physics.md#sensor_lag")},
            {{"lagged_voltage", "V"}, {"voltage_before", "V"}},
            {"fast_arc", "time_skew"},
            "a resistor on the same channels: a lag slows all of r i, an arc only its own share",
            {},
            {},
            {"fast_arc"}};
  }
  template <typename S>
  static void sense(const S* p, const InputStep& step, S& held, S& end) {
    const S& lag = p[0];
    if (step.gap || !(valueOf(lag) < 0.0)) return;
    end = S(end - lag * step.slope);
    if (!step.trace || step.duration <= 0.0) return;
    const double rise = step.trace->at(step.time) - step.trace->at(step.time - step.duration);
    held = S(held - lag * (rise / step.duration));
  }
  /// The exact filter of a voltage that is linear between samples. The states count from u_dc,
  /// where a battery rests.
  template <typename S>
  static void show(const S* p, S* x, const Instant<S>& instant, S& voltage) {
    using std::exp;
    const S now = S(voltage - instant.present.u_dc);
    const double dt = instant.duration;
    if (dt > 0.0 && valueOf(p[0]) >= 0.0) {
      const S& lag = p[0];
      // Below a fortieth of the interval nothing of the past is left, and the exponent's slope
      // would not be a number.
      const S kept = valueOf(lag) > dt / 40.0 ? S(exp(S(-dt / lag))) : S(0.0);
      const S rise = (now - x[1]) / dt;
      voltage = S(voltage - lag * rise * (1.0 - kept) + (x[0] - x[1]) * kept);
    }
    x[0] = S(voltage - instant.present.u_dc);
    x[1] = now;
  }
};

Effect sensorLag() { return effectOf<SensorLag>(); }

}  // namespace battery_sof
