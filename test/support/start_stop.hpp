#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "estimation/identification.hpp"
#include "support/composed.hpp"

/// Start-stop drives whose answers are a model's own, in the direction that is controlled.
namespace battery_sof::test {

/// A drive of a start-stop car at 1 Hz.
struct StartStopDrive {
  Series series;
  std::vector<char> controlled;  ///< one a sample, 1: a source held the voltage
};

/// What the source holds, and what the sensors add.
struct StartStopOptions {
  double duration = 900.0;               ///< [s]
  double lowest = 13.2, highest = 14.4;  ///< [V], of the source's set points
  double current_noise = 0.0, voltage_noise = 0.0;
  std::uint64_t seed = 1;
};

/**
 * Stops of 15 to 30 s under loads of 10 to 30 A, a crank of one sample at -180 to -240 A, then 45
 * to 90 s of a source whose set point changes every 10 s or so. Under load the voltage is the
 * model's, at the source the current.
 */
inline StartStopDrive startStopDrive(const BatteryModel& model, const Eigen::VectorXd& p,
                                     const StartStopOptions& options = {}) {
  Random random(options.seed), noise(options.seed + 1000);
  Simulation simulation(model, pointOf(model, p));
  StartStopDrive inputs;
  double time = 0.0, current = 0.0;
  Series clean;
  const auto take = [&](bool source, double wanted) {
    InputSample sample;
    sample.step = inputStep(clean.empty() ? time : clean.time.back(), current, time,
                            source ? 0.0 : wanted, 5.0);
    sample.voltage_controlled = source;
    sample.voltage = wanted;
    const double error = simulation.follow(sample);
    current = source ? -error : wanted;
    clean.append({time, current, source ? wanted : simulation.voltage()});
    inputs.controlled.push_back(source ? 1 : 0);
    time += 1.0;
  };
  while (time < options.duration) {
    const double stop = random.uniform(15.0, 30.0), load = random.uniform(-30.0, -10.0);
    for (double t = 0.0; t < stop; t += 1.0) take(false, load + random.uniform(-3.0, 3.0));
    take(false, random.uniform(-240.0, -180.0));
    const double runs = random.uniform(45.0, 90.0);
    double level = random.uniform(options.lowest, options.highest);
    for (double t = 0.0; t < runs; t += 1.0) {
      if (random.uniform(0.0, 1.0) < 0.1) level = random.uniform(options.lowest, options.highest);
      take(true, level);
    }
  }
  inputs.series = clean;
  for (std::size_t n = 0; n < clean.size(); ++n) {
    inputs.series.current[n] += options.current_noise * noise.normal();
    inputs.series.voltage[n] += options.voltage_noise * noise.normal();
  }
  return inputs;
}

/// A battery as fresh_sulphate has it, away from the magnitudes that a search begins at.
inline Eigen::VectorXd freshBattery(const BatteryModel& model) {
  Eigen::VectorXd p = model.typicalParameters();
  const auto set = [&](const char* name, double value) { p[*model.parameterRow(name)] = value; };
  p[kRowUDc] = 12.6;
  set("r_discharge", 0.0075);
  set("r_charge", 0.0075);
  set("fresh_exchange_current", 1.5);
  set("steady_supply", 0.8);
  set("dissolution_time", 6.0);
  return p;
}

/// The source of a drive as it was made, and what detectControlMode() finds of its rule.
inline ChargerControl knownSource(const StartStopDrive& inputs) {
  ChargerControl source;
  static_cast<ControlModes&>(source) = detectControlMode(inputs.series);
  source.voltage_controlled = inputs.controlled;
  source.seen = true;
  source.repair.dropped.assign(inputs.series.size(), 0);
  return source;
}

}  // namespace battery_sof::test
