#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "model/simulation.hpp"
#include "support/base_drive.hpp"

/// Compositions of effects driven by a known current, for tests.
namespace battery_sof::test {

/// Parameters of drivenBattery() and, for the effects, their magnitudes.
inline Eigen::VectorXd typicalPoint(const BatteryModel& model) {
  Eigen::VectorXd p = model.typicalParameters();
  const BaseParameters base = drivenBattery();
  p.head<kBaseRows>() << base.r_discharge, base.r_charge, base.c2, base.beta, base.u_dc;
  return p;
}

/// The ids with what they need.
inline std::vector<std::string> withNeeds(const std::string& id) {
  std::vector<std::string> ids = effectInfo(id).needs;
  ids.push_back(id);
  return ids;
}

/// A minute that has everything: rests, long and short charges, discharges and a pulse.
inline Series livelyMinute(double interval) {
  Series series;
  const auto current = [](double t) {
    if (t < 3.0) return 0.0;
    if (t < 6.0) return -25.0;
    if (t < 7.0) return -260.0;
    if (t < 9.0) return -40.0;
    if (t < 30.0) return 35.0;
    if (t < 33.0) return 0.4;
    if (t < 40.0) return -12.0;
    if (t < 42.0) return 60.0;
    if (t < 50.0) return -70.0;
    return 1.5;
  };
  for (long n = 0; n * interval < 60.0; ++n) {
    series.time.push_back(n * interval);
    series.current.push_back(current(n * interval));
    series.voltage.push_back(12.5);
  }
  return series;
}

inline ModelPoint pointOf(const BatteryModel& model, const Eigen::VectorXd& parameters) {
  return {parameters, model.restState(), 0.0, 0.0};
}

/// Voltages of a composition over a drive.
inline std::vector<double> voltages(const BatteryModel& model, const ModelPoint& start,
                                    const InputSequence& inputs) {
  Simulation simulation(model, start);
  std::vector<double> u;
  for (const InputSample& sample : inputs.samples) {
    simulation.advance(sample.step);
    u.push_back(simulation.voltage());
  }
  return u;
}

inline IndexRange whole(const Series& series) { return {0, series.size()}; }

/// Minutes of a composition at 20 Hz with 2 mV of noise.
inline Series recordingOf(const std::vector<std::string>& effects, double duration) {
  const BatteryModel model(effects);
  Series series;
  series.current = dataSetOneCurrent(duration, 0.05, 6);
  for (std::size_t n = 0; n < series.current.size(); ++n)
    series.time.push_back(0.05 * static_cast<double>(n));
  series.voltage.assign(series.time.size(), 0.0);
  series.voltage =
      voltages(model, pointOf(model, typicalPoint(model)), inputSequence(series, whole(series)));
  Random random(66);
  for (double& u : series.voltage) u += 0.002 * random.normal();
  return series;
}

}  // namespace battery_sof::test
