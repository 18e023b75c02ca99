#pragma once

#include "recording/control_mode.hpp"
#include "state/state_estimator.hpp"
#include "support/known_model.hpp"
#include "support/synthetic_recording.hpp"

/// Drives of a car whose source controls the voltage, at one sample a second, answered by a model
/// that is known exactly.
namespace battery_sof::test {

/// What is put wrong in the voltage channel.
struct VoltageFaults {
  std::size_t lag = 0;        ///< [samples], by which it is behind the current
  std::size_t drop_each = 0;  ///< [samples], between drop-outs; 0 for none
};

/// Stops of 8 to 20 s, a crank, then a source that holds 13.4 to 14.6 V and moves every few
/// seconds.
inline Series sourcedDrive(std::size_t samples, const FittedModel& battery, std::uint64_t seed,
                           const VoltageFaults& faults = {}) {
  Random random(seed);
  StateEstimator follower(battery, false);
  MissedCrank missed;
  Series series;
  std::vector<double> shown;
  double current = battery.state.current, held = 14.0, stop_until = 0.0, next_stop = 20.0,
         next_level = 0.0;
  for (std::size_t n = 0; n < samples; ++n) {
    const auto t = static_cast<double>(n);
    if (t >= next_stop) {
      stop_until = t + std::floor(random.uniform(8.0, 20.0));
      next_stop = stop_until + random.uniform(25.0, 50.0);
    }
    if (t >= next_level) {
      held = random.uniform(13.4, 14.6);
      next_level = t + random.uniform(3.0, 12.0);
    }
    InputSample sample;
    sample.voltage_controlled = t >= stop_until + 1.0;
    sample.voltage = held + 0.02 * random.normal();
    const double drawn =
        t < stop_until ? random.uniform(-28.0, -18.0) : random.uniform(-220.0, -180.0);
    const double before = battery.state.time + t;
    sample.step = inputStep(before, current, before + 1.0, drawn, 10.0);
    sample.step.missed =
        missed.add(1.0, sample.voltage_controlled ? 10.0 : drawn, sample.voltage_controlled);
    // the current that goes with the voltage
    for (int k = 0; k < 3 && sample.voltage_controlled; ++k) {
      const double missed_before = sample.step.missed;
      StateEstimator trial = follower;
      sample.step = inputStep(before, current, before + 1.0, trial.predict(sample).current, 10.0);
      sample.step.missed = missed_before;
    }
    const FollowedSample at = follower.predict(sample);
    current = at.current;
    series.time.push_back(before + 1.0);
    series.current.push_back(at.current + 0.1 * random.normal());
    shown.push_back(at.voltage + 0.005 * random.normal());
  }
  for (std::size_t n = 0; n < samples; ++n) {
    series.voltage.push_back(shown[n < faults.lag ? 0 : n - faults.lag]);
    if (faults.drop_each > 0 && n % faults.drop_each == faults.drop_each - 1 &&
        series.current[n] > -60.0)
      series.voltage[n] -= 1.5;
  }
  return series;
}

}  // namespace battery_sof::test
