#include "simulator/full_battery.hpp"
#include "simulator/generator/law.hpp"
#include "simulator/generator/series.hpp"
#include "simulator/units.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kStep = FullBattery::kStep;  // [s]

Law instrument(double max_strength, std::function<Course(const Course&, double)> shown) {
  Law law;
  law.shown = std::move(shown);
  law.max_strength = max_strength;
  return law;
}

/**
 * A vehicle's sensor that shows next to nothing of small currents.
 *
 *     i_shown = i (1 - 1 / (1 + (i / s i_d)^4)),   i_d 1 to 3 A
 *
 * Zero-clamping of shunt amplifiers to hide their offset.
 */
Law deadBand(Dice& dice, const Circumstances&) {
  const double width = dice.between({1.0, 3.0});
  return instrument(2.0, [=](const Course& truth, double strength) {
    Course course = truth;
    const double band = strength * width;
    if (band <= 0.0) return course;
    for (double& current : course.current) {
      const double x = current / band, fourth = x * x * x * x;
      current *= fourth / (1.0 + fourth);
    }
    return course;
  });
}

/**
 * A sensor whose core stays magnetised by the last large current.
 *
 *     m <- clamp(m + di / i_m, -1, 1),   i_shown = i + s 0.5 A m,   i_m 60 to 250 A
 *
 * Remanence as an elastic and plastic element of current (Preisach 1935); open-loop Hall sensors
 * show 0.2 to 1 A of it after a crank (data sheets).
 */
Law remanence(Dice& dice, const Circumstances&) {
  const double reach = dice.between({60.0, 250.0});
  return instrument(4.0, [=](const Course& truth, double strength) {
    Course course = truth;
    double magnetised = 0.0;
    for (std::size_t n = 1; n < truth.current.size(); ++n) {
      const double moved = (truth.current[n] - truth.current[n - 1]) / reach;
      magnetised = std::clamp(magnetised + moved, -1.0, 1.0);
      course.current[n] += strength * 0.5 * magnetised;
    }
    return course;
  });
}

/**
 * Two loggers whose clocks run apart.
 *
 *     u_shown(t) = u(t - d(t)),   d = s d_1 [t / T + 0.2 sin(2 pi t / T_w)]
 *
 * d_1 one sample of the recording, at least 20 ms; crystals differ by 10 to 100 ppm and wander with
 * the temperature.
 */
Law clockDrift(Dice& dice, const Circumstances& drive) {
  const double length = drive.duration,
               reach =
                   std::max(0.02, 1.0 / drive.sample_rate_hz) * (dice.share() < 0.5 ? -1.0 : 1.0),
               wander = dice.between({0.1, 0.4}) * drive.duration;
  return instrument(4.0, [=](const Course& truth, double strength) {
    Course course = truth;
    if (strength == 0.0) return course;
    for (std::size_t n = 0; n < truth.voltage.size(); ++n) {
      const double time = static_cast<double>(n) * kStep;
      const double delay = reach * (time / length + 0.2 * std::sin(2.0 * kPi * time / wander));
      course.voltage[n] = valueAt(truth.voltage, static_cast<double>(n) - strength * delay / kStep);
    }
    return course;
  });
}

/**
 * A voltage channel that rings.
 *
 *     y'' + 2 z w y' + w^2 y = w^2 u,   u_shown = u + s (y - u),   z 0.15 to 0.4
 *
 * Period four to ten samples, at least 60 ms. An active filter near its limit of stability.
 */
Law ringingChannel(Dice& dice, const Circumstances& drive) {
  const double period = std::max(0.06, dice.between({4.0, 10.0}) / drive.sample_rate_hz),
               damping = dice.between({0.15, 0.4});
  return instrument(1.0, [=](const Course& truth, double strength) {
    Course course = truth;
    const double w = 2.0 * kPi / period;
    double y = truth.voltage.front(), rate = 0.0;
    for (std::size_t n = 0; n < truth.voltage.size(); ++n) {
      rate += kStep * (w * w * (truth.voltage[n] - y) - 2.0 * damping * w * rate);
      y += kStep * rate;
      course.voltage[n] += strength * (y - truth.voltage[n]);
    }
    return course;
  });
}

/**
 * A consumer past the sensor that a thermostat switches.
 *
 *     i_shown = i + s 1 A g(t),   g: 1 for a share 0.3 to 0.7 of each period of 40 to 200 s, edges of 1 s
 *
 * A relay's cycle, not a constant load. The battery's current is below what is shown.
 */
Law thermostatLoad(Dice& dice, const Circumstances& drive) {
  const double period = std::min(dice.between({40.0, 200.0}), drive.duration / 8.0),
               on = dice.between({0.3, 0.7}), phase = dice.share();
  return instrument(4.0, [=](const Course& truth, double strength) {
    Course course = truth;
    for (std::size_t n = 1; n < truth.current.size(); ++n) {
      const double cycles = static_cast<double>(n) * kStep / period + phase;
      const double inside = (cycles - std::floor(cycles)) * period;  // [s] since switched on
      course.current[n] += strength * (smoothStep(inside) - smoothStep(inside - on * period));
    }
    return course;
  });
}

}  // namespace

std::vector<LawForm> instrumentLaws() {
  return {{"instrument", "dead_band", deadBand},
          {"instrument", "remanence", remanence},
          {"instrument", "clock_drift", clockDrift},
          {"instrument", "ringing_channel", ringingChannel},
          {"instrument", "thermostat_load", thermostatLoad}};
}

}  // namespace battery_sof_simulator
