#include "battery_sof/predict/state_tracker.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace battery_sof {
namespace {

constexpr double kOhmsOfCurrentError = 0.01;  // [Ohm], r_charge's magnitude
constexpr double kTraceKept = 1.0;  // [s], far more than any shift between channels

}  // namespace

StateTracker::StateTracker(const FittedModel& model, double max_gap)
    : model_(model),
      follower_(model, true),
      state_(model.state),
      errors_(model),
      error_time_(model.state.time),
      max_gap_(max_gap),
      needs_trace_(!model.effects.empty()) {
  if (model.source) watch_.emplace(*model.source);
  if (needs_trace_) trace_.append(state_.time, state_.current, max_gap_);
}

void StateTracker::follow(double time, double current, double voltage) {
  if (!(time > state_.time))
    throw std::invalid_argument("StateTracker: time " + std::to_string(time) +
                                " s is not after the state's " + std::to_string(state_.time) +
                                " s");
  DriveSample sample;
  sample.step = driveStep(state_.time, state_.current, time, current, max_gap_);
  DriveStep& step = sample.step;
  sample.voltage = voltage;
  sample.voltage_drives = watch_ && watch_->add(time, current, voltage);
  if (watch_) step.missed = missed_.add(step.duration, current, sample.voltage_drives);
  if (needs_trace_) {
    trace_.append(time, current, max_gap_);
    trace_.forgetBefore(time - kTraceKept);
    step.trace = &trace_;
  }
  last_ = follower_.follow(sample);
  error_ = sample.voltage_drives ? kOhmsOfCurrentError * (current - last_.current) : voltage - last_.voltage;
  const Eigen::VectorXd state = simulation().state();
  state_.time = time;
  state_.current = current;
  state_.u_c2 = state[0];
  state_.further.assign(state.data() + 1, state.data() + state.size());
  if (sample.voltage_drives) return;
  errors_.observe(state_.time - error_time_, error_);
  error_time_ = state_.time;
}


void StateTracker::setScales(const IntervalScale& crank, const IntervalScale& charge) {
  model_.crank_scale = crank;
  model_.charge_scale = charge;
}

FittedModel StateTracker::modelNow() const {
  FittedModel now = model_;
  ErrorTracker errors = errors_;
  if (state_.time > error_time_) errors.wait(state_.time - error_time_);
  now.discrepancy = errors.discrepancy();
  takeState(now, follower_, state_.current);
  return now;
}

void setStateFromVoltage(FittedModel& model, double time, double current, double voltage) {
  const BatteryModel composition = compositionOf(model);
  model.state.time = time;
  model.state.current = current;
  Simulation here = uncertainSimulationOf(model);
  DriveStep now;
  now.time = time;
  now.held = now.current = current;
  here.advance(now);
  const double missing = voltage - here.voltage();

  const Eigen::Index parameters = composition.parameterCount();
  const Eigen::MatrixXd factor = covarianceFactor(model.covariance);
  const double own = std::pow(model.scores.rmse, 2);
  Eigen::MatrixXd moved = factor;
  Eigen::VectorXd unshared = Eigen::VectorXd::Zero(factor.rows());
  for (Eigen::Index j = 0; j < composition.stateCount(); ++j) {
    const bool follows = j == 0 || composition.states()[static_cast<std::size_t>(j)].begins_as_u_c2;
    if (!follows) continue;
    // du/du_c2 is one, so what the voltage does not know beside u_c2 is what u_c2 takes over.
    (j == 0 ? model.state.u_c2 : model.state.further[static_cast<std::size_t>(j) - 1]) += missing;
    if (factor.cols() > 0)
      moved.row(parameters + j) = factor.row(parameters) - here.voltageDerivatives().transpose();
    unshared[parameters + j] = std::sqrt(own);
  }
  model.covariance = moved * moved.transpose() + unshared * unshared.transpose();
}

}  // namespace battery_sof
