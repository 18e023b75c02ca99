#include "simulator/out_of_model_instrument.hpp"

#include <algorithm>
#include <cmath>

#include "simulator/pi.hpp"

namespace battery_sof_reference {
namespace {

constexpr double kStep = OutOfModelBattery::kStep;  // [s]

/// A value of a series at a position between its entries; its ends are held.
double at(const std::vector<double>& series, double position) {
  const double inside = std::clamp(position, 0.0, static_cast<double>(series.size() - 1));
  const auto before = static_cast<std::size_t>(inside);
  const std::size_t after = std::min(before + 1, series.size() - 1);
  return series[before] + (inside - static_cast<double>(before)) * (series[after] - series[before]);
}

/**
 * A vehicle's sensor that shows next to nothing of small currents.
 *
 *     i_shown = i (1 - 1 / (1 + (i / s i_d)^4)),   i_d 1 to 3 A
 *
 * Zero-clamping of shunt amplifiers to hide their offset.
 */
class DeadBand : public OutOfModelInstrument {
 public:
  DeadBand(Dice& dice, const Circumstances&) : band_(dice.between({1.0, 3.0})) {}

  Course shown(const Course& truth, double strength) const override {
    Course course = truth;
    const double band = strength * band_;
    if (band <= 0.0) return course;
    for (double& current : course.current) {
      const double x = current / band, fourth = x * x * x * x;
      current *= fourth / (1.0 + fourth);
    }
    return course;
  }

 private:
  double band_;
};

/**
 * A sensor whose core stays magnetised by the last large current.
 *
 *     m <- clamp(m + di / i_m, -1, 1),   i_shown = i + s 0.5 A m,   i_m 60 to 250 A
 *
 * Remanence as an elastic and plastic element of current (Preisach 1935); open-loop Hall sensors
 * show 0.2 to 1 A of it after a crank (data sheets).
 */
class Remanence : public OutOfModelInstrument {
 public:
  Remanence(Dice& dice, const Circumstances&) : reach_(dice.between({60.0, 250.0})) {}

  Course shown(const Course& truth, double strength) const override {
    Course course = truth;
    double magnetised = 0.0;
    for (std::size_t n = 1; n < truth.current.size(); ++n) {
      const double moved = (truth.current[n] - truth.current[n - 1]) / reach_;
      magnetised = std::clamp(magnetised + moved, -1.0, 1.0);
      course.current[n] += strength * 0.5 * magnetised;
    }
    return course;
  }

 private:
  double reach_;
};

/**
 * Two loggers whose clocks run apart.
 *
 *     u_shown(t) = u(t - d(t)),   d = s d_1 [t / T + 0.2 sin(2 pi t / T_w)]
 *
 * d_1 one sample of the recording, at least 20 ms; crystals differ by 10 to 100 ppm and wander with
 * the temperature.
 */
class ClockDrift : public OutOfModelInstrument {
 public:
  ClockDrift(Dice& dice, const Circumstances& drive)
      : length_(drive.duration),
        reach_(std::max(0.02, 1.0 / drive.sample_rate_hz) * (dice.share() < 0.5 ? -1.0 : 1.0)),
        random_walk_(dice.between({0.1, 0.4}) * drive.duration) {}

  Course shown(const Course& truth, double strength) const override {
    Course course = truth;
    if (strength == 0.0) return course;
    for (std::size_t n = 0; n < truth.voltage.size(); ++n) {
      const double time = static_cast<double>(n) * kStep;
      const double delay =
          reach_ * (time / length_ + 0.2 * std::sin(2.0 * kPi * time / random_walk_));
      course.voltage[n] = at(truth.voltage, static_cast<double>(n) - strength * delay / kStep);
    }
    return course;
  }

 private:
  double length_, reach_, random_walk_;
};

/**
 * A voltage channel that rings.
 *
 *     y'' + 2 z w y' + w^2 y = w^2 u,   u_shown = u + s (y - u),   z 0.15 to 0.4
 *
 * Period four to ten samples, at least 60 ms. An active filter near its limit of stability.
 */
class RingingChannel : public OutOfModelInstrument {
 public:
  RingingChannel(Dice& dice, const Circumstances& drive)
      : period_(std::max(0.06, dice.between({4.0, 10.0}) / drive.sample_rate_hz)),
        damping_(dice.between({0.15, 0.4})) {}

  Course shown(const Course& truth, double strength) const override {
    Course course = truth;
    const double w = 2.0 * kPi / period_;
    double y = truth.voltage.front(), rate = 0.0;
    for (std::size_t n = 0; n < truth.voltage.size(); ++n) {
      rate += kStep * (w * w * (truth.voltage[n] - y) - 2.0 * damping_ * w * rate);
      y += kStep * rate;
      course.voltage[n] += strength * (y - truth.voltage[n]);
    }
    return course;
  }

 private:
  double period_, damping_;
};

/**
 * A consumer past the sensor that a thermostat switches.
 *
 *     i_shown = i + s 1 A g(t),   g: 1 for a share 0.3 to 0.7 of each period of 40 to 200 s, edges
 * of 1 s
 *
 * A relay's cycle, not a constant load. The battery's current is below what is shown.
 */
class ThermostatLoad : public OutOfModelInstrument {
 public:
  ThermostatLoad(Dice& dice, const Circumstances& drive)
      : period_(std::min(dice.between({40.0, 200.0}), drive.duration / 8.0)),
        on_(dice.between({0.3, 0.7})),
        phase_(dice.share()) {}

  Course shown(const Course& truth, double strength) const override {
    Course course = truth;
    for (std::size_t n = 1; n < truth.current.size(); ++n) {
      const double cycles = static_cast<double>(n) * kStep / period_ + phase_;
      const double inside = (cycles - std::floor(cycles)) * period_;  // [s] since switched on
      const double drawn = smoothStep(inside) - smoothStep(inside - on_ * period_);
      course.current[n] += strength * drawn;
    }
    return course;
  }

 private:
  double period_, on_, phase_;
};

template <typename Law>
OutOfModelInstrumentForm instrumentOf(const std::string& id, double max_strength) {
  return {id, max_strength,
          [](Dice& dice, const Circumstances& drive) -> std::unique_ptr<OutOfModelInstrument> {
            return std::make_unique<Law>(dice, drive);
          }};
}

}  // namespace

const std::vector<OutOfModelInstrumentForm>& outOfModelInstrumentForms() {
  static const std::vector<OutOfModelInstrumentForm> all{
      instrumentOf<DeadBand>("dead_band", 2.0), instrumentOf<Remanence>("remanence", 4.0),
      instrumentOf<ClockDrift>("clock_drift", 4.0),
      instrumentOf<RingingChannel>("ringing_channel", 1.0),
      instrumentOf<ThermostatLoad>("thermostat_load", 4.0)};
  return all;
}

}  // namespace battery_sof_reference
