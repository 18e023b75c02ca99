#include "state/state_estimator.hpp"

#include <algorithm>

#include "recording/voltage_repair.hpp"

namespace battery_sof {

StateEstimator::StateEstimator(const FittedModel& model, bool uncertain)
    : simulation_(uncertain ? uncertainSimulationOf(model) : simulationOf(model)),
      residual_regression_(model.fit.residual_regression),
      state_(model.state),
      errors_(model),
      has_source_(model.fit.source) {
  // A source's ramp begins at the voltage that the state represents.
  InputStep here;
  here.time = state_.time;
  here.held = here.current = state_.current;
  simulation_.advance(here);
  errors_.expectStop();
}

FollowedSample StateEstimator::predict(InputSample sample) {
  if (has_source_)
    sample.step.missed = state_.missed_crank.add(sample.step.duration, sample.step.current,
                                                 sample.voltage_controlled);
  FollowedSample out;
  out.voltage_controlled = sample.voltage_controlled;
  out.physics_error = simulation_.follow(sample);
  const bool has_tangents = simulation_.tangents() > 0;
  if (sample.voltage_controlled) {
    out.voltage = sample.voltage;
    out.current = sample.step.current - out.physics_error;
    if (has_tangents) out.variance = simulation_.currentErrorDerivatives().squaredNorm();
  } else {
    out.voltage = simulation_.voltage();
    out.current = sample.step.current;
    if (has_tangents) out.variance = simulation_.voltageDerivatives().squaredNorm();
  }
  out.columns = state_.memory.advance(
      {sample.step.duration, sample.voltage_controlled, out.voltage, out.current});
  const RidgeFit& fit =
      sample.voltage_controlled ? residual_regression_.current : residual_regression_.voltage;
  out.regression_correction = fit.at(out.columns);
  if (sample.voltage_controlled && !fit.empty())
    out.regression_correction =
        std::clamp(out.current + out.regression_correction, residual_regression_.min_current,
                   residual_regression_.max_current) -
        out.current;
  (sample.voltage_controlled ? out.current : out.voltage) += out.regression_correction;
  const Eigen::VectorXd state = simulation_.state();
  state_.time = sample.step.time;
  state_.current = sample.step.current;
  state_.u_c2 = state[0];
  state_.further.assign(state.data() + 1, state.data() + state.size());
  return out;
}

FollowedSample StateEstimator::follow(const InputSample& sample) {
  FollowedSample followed = predict(sample);
  update(sample, sample.voltage - followed.voltage);
  return followed;
}

void StateEstimator::saveTo(FittedModel& model) const {
  takeState(model, simulation_, state_.current);
  model.state.memory = state_.memory;
  model.state.missed_crank = state_.missed_crank;
  model.state.residual_state = errors_.residualState();
}

InputSequence inputsOf(const Fit& fit, const Series& series, IndexRange range) {
  if (!fit.source || range.empty()) return inputSequence(series, range);
  // Judged as live: from a little before the range on, sample by sample.
  std::vector<char> controlled(series.size(), 0);
  ControlModeDetector watch(*fit.source);
  std::size_t n = range.first;
  while (n > 0 && series.time[range.first] - series.time[n - 1] < kControlModeLookBack) --n;
  for (; n < range.last; ++n)
    controlled[n] = watch.add(series.time[n], series.current[n], series.voltage[n]);
  VoltageRepair repair;
  repair.lag = fit.voltage_lag;
  for (std::size_t k = 0; k < series.size(); ++k) repair.dropped.push_back(isDropOut(series, k));
  return inputSequence(repaired(series, repair), range, {}, controlled);
}

}  // namespace battery_sof
