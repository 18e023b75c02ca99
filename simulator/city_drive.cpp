#include "simulator/city_drive.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "simulator/drive_plan.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kStep = 0.001;      // [s]
constexpr int kStepsPerSample = 10;  // 1 kHz to 100 Hz
constexpr double kSlew = 3000.0;     // [A/s], wiring and starter inductance

void appendRound(Dice& dice, std::vector<Phase>& phases) {
  const double load = dice.between({-30.0, 0.0});
  phases.push_back({dice.between({3.0, 12.0}), load, load});
  const double cruise = dice.between({3.0, 20.0});
  phases.push_back({dice.between({4.0, 25.0}), cruise, cruise});
  if (dice.between({0.0, 1.0}) > 0.8) return;
  const double braking = dice.between({45.0, 80.0});
  phases.push_back({dice.between({4.0, 15.0}), braking, 0.6 * braking});
}

std::vector<Phase> plannedPhases(Dice& dice, double duration) {
  std::vector<Phase> phases;
  double planned = 0.0;
  while (planned < duration) {
    const std::size_t before = phases.size();
    const double consumers = dice.between({-35.0, -15.0});
    phases.push_back(steady(dice.between({8.0, 40.0}), consumers));
    phases.push_back(steady(0.12, dice.between({-300.0, -230.0})));
    const double cranking = dice.between({-180.0, -120.0});
    phases.push_back(steady(dice.between({0.3, 0.7}), cranking));
    const int rounds = 2 + static_cast<int>(dice.between({0.0, 3.0}));
    for (int k = 0; k < rounds; ++k) appendRound(dice, phases);
    for (std::size_t k = before; k < phases.size(); ++k) planned += phases[k].duration;
  }
  return phases;
}

double stateRate(const Circuit& c, double u, double current) {
  const double through = 2.0 * c.exchange_current * std::sinh(0.5 * c.beta * u);
  return (current - through) / c.capacitance;
}

double rungeKutta(const Circuit& c, double u, double current) {
  const double k1 = stateRate(c, u, current);
  const double k2 = stateRate(c, u + 0.5 * kStep * k1, current);
  const double k3 = stateRate(c, u + 0.5 * kStep * k2, current);
  const double k4 = stateRate(c, u + kStep * k3, current);
  return u + kStep / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

double voltageAt(const Circuit& c, double u, double current) {
  return c.u_dc + u + (current < 0.0 ? c.r_discharge : c.r_charge) * current;
}

void requireValid(const CityDriveOptions& o) {
  if (!(o.duration > 0.0) || !std::isfinite(o.duration))
    throw std::invalid_argument("duration is " + std::to_string(o.duration) +
                                " s, expected above 0");
  for (double value : {o.voltage_noise, o.current_noise, o.voltage_step, o.current_step})
    if (!(value >= 0.0)) throw std::invalid_argument("noise and quantisation must not be negative");
}

/// Steps battery, alternator and wiring through the planned phases.
class Car {
 public:
  Car(const CityDriveOptions& options, std::vector<Phase> phases)
      : options_(options), phases_(std::move(phases)) {}

  void step() {
    const double wanted = std::min(plannedCurrent(), limitedCurrent());
    current_ += std::clamp(wanted - current_, -kSlew * kStep, kSlew * kStep);
    u_ = rungeKutta(options_.circuit, u_, current_);
    into_phase_ += kStep;
    if (into_phase_ >= phases_[phase_].duration && phase_ + 1 < phases_.size()) {
      ++phase_;
      into_phase_ = 0.0;
    }
  }
  double current() const { return current_; }
  double voltage() const { return voltageAt(options_.circuit, u_, current_); }

 private:
  double plannedCurrent() const {
    const Phase& phase = phases_[phase_];
    const double share = std::min(into_phase_ / phase.duration, 1.0);
    return phase.begin + share * (phase.end - phase.begin);
  }
  /// Charging current that holds the alternator's set point.
  double limitedCurrent() const {
    const auto& c = options_.circuit;
    return std::max(0.0, (options_.voltage_limit - c.u_dc - u_) / c.r_charge);
  }

  CityDriveOptions options_;
  std::vector<Phase> phases_;
  std::size_t phase_ = 0;
  double into_phase_ = 0.0;
  double current_ = 0.0;
  double u_ = 0.0;
};

}  // namespace

std::vector<RecordedSample> simulateCityDrive(const CityDriveOptions& options) {
  requireValid(options);
  Dice dice(options.seed);
  Car car(options, plannedPhases(dice, options.duration));
  const auto count = static_cast<std::size_t>(options.duration / (kStep * kStepsPerSample));
  std::vector<RecordedSample> samples;
  samples.reserve(count);
  for (std::size_t n = 0; n < count; ++n) {
    double current = 0.0;
    double voltage = 0.0;
    for (int k = 0; k < kStepsPerSample; ++k) {
      car.step();
      current += car.current() / kStepsPerSample;
      voltage += car.voltage() / kStepsPerSample;
    }
    samples.push_back(
        {static_cast<double>(n) * kStep * kStepsPerSample,
         quantised(current + options.current_noise * dice.normal(), options.current_step),
         quantised(voltage + options.voltage_noise * dice.normal(), options.voltage_step)});
  }
  return samples;
}

}  // namespace battery_sof_simulator
