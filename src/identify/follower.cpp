#include "battery_sof/identify/follower.hpp"

namespace battery_sof {

Follower::Follower(const FittedModel& model, bool uncertain)
    : simulation_(uncertain ? uncertainSimulationOf(model) : simulationOf(model)),
      memory_(model.state.memory),
      learned_(model.learned) {}

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
  (sample.voltage_drives ? out.current : out.voltage) += out.learned;
  return out;
}

void takeState(FittedModel& model, const Follower& follower, double current) {
  takeState(model, follower.simulation(), current);
  model.state.memory = follower.memory();
}

}  // namespace battery_sof
