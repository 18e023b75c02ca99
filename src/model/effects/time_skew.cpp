#include "effect_definition.hpp"

namespace battery_sof {

struct TimeSkew {
  static constexpr bool kActsAtEdges = true;

  static EffectInfo info() {
    return {"time_skew",
            "I3",
            "current and voltage channels are shifted in time",
            "i(t) = i_measured(t - d); d > 0: the voltage comes late",
            {strength("channel_skew", "d", "s", 0.01, -2.5, 2.5,
                      "docs/physics.md#time_skew; bounds: two samples of a logger at 1 Hz")},
            {},
            {"inductance", "fast_arc", "sensor_lag"},
            "edges up and down: the error is antisymmetric and follows r di/dt"};
  }
  template <typename S>
  static void sense(const S* p, const InputStep& step, S& held, S& end) {
    if (step.gap) return;
    const S& skew = p[0];
    const double d = valueOf(skew);
    if (!step.trace) {
      held = S(held - skew * step.slope);
      end = S(end - skew * step.slope);
      return;
    }
    const CurrentTrace& trace = *step.trace;
    const auto shifted = [&](const S& mean, double from, double to) {
      const double moved = trace.meanBetween(from - d, to - d) - trace.meanBetween(from, to);
      const double rate = (trace.at(to - d) - trace.at(from - d)) / (to - from);
      return S(mean + moved - rate * (skew - d));
    };
    const double time = step.time;
    end =
        step.span > 0.0
            ? shifted(end, time - 0.5 * step.span, time + 0.5 * step.span)
            : S(end + (trace.at(time - d) - trace.at(time)) - trace.slopeAt(time - d) * (skew - d));
    if (step.duration > 0.0) held = shifted(held, time - step.duration, time);
  }
};

Effect timeSkew() { return effectOf<TimeSkew>(); }

}  // namespace battery_sof
