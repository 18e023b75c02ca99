#include "simulator/city_drive.hpp"

#include <algorithm>
#include <stdexcept>

#include "simulator/drive_plan.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kStep = 0.001;         // [s]
constexpr int kStepsPerSample = 10;     // 1 kHz to 100 Hz
constexpr double kSlew = 3000.0;        // [A/s], wiring and starter inductance
constexpr double kVoltageLimit = 14.2;  // [V], set point of the alternator
constexpr double kVoltageNoise = 0.002, kVoltageStep = 0.001;  // [V]
constexpr double kCurrentNoise = 0.05, kCurrentStep = 0.01;    // [A]
// The battery: the paper's Fig. 3 circuit, written here a second time and on purpose.
constexpr double kDischargeOhm = 0.006, kChargeOhm = 0.0085;
constexpr double kCapacitance = 1100.0;                 // C_2 [F]
constexpr double kExchangeCurrent = 1.0, kBeta = 22.0;  // I_0 [A], [1/V], alpha = 0.5
constexpr double kOpenCircuit = 12.7;                   // u_dc [V]

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

double stateRate(double u, double current) {
  return (current - 2.0 * kExchangeCurrent * std::sinh(0.5 * kBeta * u)) / kCapacitance;
}

double rungeKutta(double u, double current) {
  const double k1 = stateRate(u, current);
  const double k2 = stateRate(u + 0.5 * kStep * k1, current);
  const double k3 = stateRate(u + 0.5 * kStep * k2, current);
  const double k4 = stateRate(u + kStep * k3, current);
  return u + kStep / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

/// Steps battery, alternator and wiring through the planned phases.
class Car {
 public:
  explicit Car(std::vector<Phase> phases) : phases_(std::move(phases)) {}

  void step() {
    const double wanted = std::min(plannedCurrent(), limitedCurrent());
    current_ += std::clamp(wanted - current_, -kSlew * kStep, kSlew * kStep);
    u_ = rungeKutta(u_, current_);
    into_phase_ += kStep;
    if (into_phase_ >= phases_[phase_].duration && phase_ + 1 < phases_.size()) {
      ++phase_;
      into_phase_ = 0.0;
    }
  }
  double current() const { return current_; }
  double voltage() const {
    return kOpenCircuit + u_ + (current_ < 0.0 ? kDischargeOhm : kChargeOhm) * current_;
  }

 private:
  double plannedCurrent() const {
    const Phase& phase = phases_[phase_];
    const double share = std::min(into_phase_ / phase.duration, 1.0);
    return phase.begin + share * (phase.end - phase.begin);
  }
  /// Charging current that holds the alternator's set point.
  double limitedCurrent() const {
    return std::max(0.0, (kVoltageLimit - kOpenCircuit - u_) / kChargeOhm);
  }

  std::vector<Phase> phases_;
  std::size_t phase_ = 0;
  double into_phase_ = 0.0, current_ = 0.0, u_ = 0.0;
};

}  // namespace

std::vector<RecordedSample> simulateCityDrive(const CityDriveOptions& options) {
  if (!(options.duration > 0.0) || !std::isfinite(options.duration))
    throw std::invalid_argument("duration is " + std::to_string(options.duration) +
                                " s, expected above 0");
  Dice dice(options.seed);
  Car car(plannedPhases(dice, options.duration));
  const auto count = static_cast<std::size_t>(options.duration / (kStep * kStepsPerSample));
  std::vector<RecordedSample> samples;
  samples.reserve(count);
  for (std::size_t n = 0; n < count; ++n) {
    double current = 0.0, voltage = 0.0;
    for (int k = 0; k < kStepsPerSample; ++k) {
      car.step();
      current += car.current() / kStepsPerSample;
      voltage += car.voltage() / kStepsPerSample;
    }
    samples.push_back({static_cast<double>(n) * kStep * kStepsPerSample,
                       quantised(current + kCurrentNoise * dice.normal(), kCurrentStep),
                       quantised(voltage + kVoltageNoise * dice.normal(), kVoltageStep)});
  }
  return samples;
}

}  // namespace battery_sof_simulator
