#include "battery_sof/identify/follower.hpp"

#include <algorithm>

#include "battery_sof/recording/voltage_repair.hpp"

namespace battery_sof {
namespace {

constexpr double kLookBack = 300.0;  // [s], of a source's past that its judgement rests on

}  // namespace

Follower::Follower(const FittedModel& model, bool uncertain)
    : simulation_(uncertain ? uncertainSimulationOf(model) : simulationOf(model)),
      memory_(model.state.memory),
      learned_(model.fit.learned) {
  // A source's ramp begins at the voltage that the state stands for.
  DriveStep here;
  here.time = model.state.time;
  here.held = here.current = model.state.current;
  simulation_.advance(here);
}

FollowedSample Follower::follow(const DriveSample& sample) {
  FollowedSample out;
  out.voltage_drives = sample.voltage_drives;
  out.physics_error = simulation_.follow(sample);
  const bool has_lanes = simulation_.lanes() > 0;
  if (sample.voltage_drives) {
    out.voltage = sample.voltage;
    out.current = sample.step.current - out.physics_error;
    if (has_lanes) out.variance = simulation_.currentErrorDerivatives().squaredNorm();
  } else {
    out.voltage = simulation_.voltage();
    out.current = sample.step.current;
    if (has_lanes) out.variance = simulation_.voltageDerivatives().squaredNorm();
  }
  out.columns = memory_.advance({sample.step.duration, sample.voltage_drives, out.voltage, out.current});
  const RidgeFit& fit = sample.voltage_drives ? learned_.current : learned_.voltage;
  out.learned = fit.at(out.columns);
  if (sample.voltage_drives && !fit.empty())
    out.learned = std::clamp(out.current + out.learned, learned_.least_current, learned_.most_current) - out.current;
  (sample.voltage_drives ? out.current : out.voltage) += out.learned;
  return out;
}

Drive driveOf(const Fit& fit, const Series& series, IndexRange range) {
  if (!fit.source || range.empty()) return fullDrive(series, range);
  // Judged as live: from a little before the range on, sample by sample.
  std::vector<char> imposed(series.size(), 0);
  SourceWatch watch(*fit.source);
  std::size_t n = range.first;
  while (n > 0 && series.time[range.first] - series.time[n - 1] < kLookBack) --n;
  for (; n < range.last; ++n) imposed[n] = watch.add(series.time[n], series.current[n], series.voltage[n]);
  VoltageRepair repair;
  repair.lag = fit.voltage_lag;
  for (std::size_t k = 0; k < series.size(); ++k) repair.dropped.push_back(isDropOut(series, k));
  return fullDrive(repaired(series, repair), range, {}, imposed);
}

void takeState(FittedModel& model, const Follower& follower, double current) {
  takeState(model, follower.simulation(), current);
  model.state.memory = follower.memory();
}

}  // namespace battery_sof
