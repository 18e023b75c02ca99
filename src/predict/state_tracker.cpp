#include "battery_sof/predict/state_tracker.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "battery_sof/identify/identification.hpp"
#include "battery_sof/model/driving_current.hpp"

namespace battery_sof {

StateTracker::StateTracker(const FittedModel& model, double max_gap)
    : model_(model),
      step_(model.parameters),
      overpotential_{model.state.u_c2, 1.0, 0.0, 0.0},
      state_(model.state),
      max_gap_(max_gap) {}

void StateTracker::advance(double time, double current) {
  if (!(time > state_.time))
    throw std::invalid_argument("StateTracker: time " + std::to_string(time) +
                                " s is not after the state's " + std::to_string(state_.time) +
                                " s");
  const HeldCurrent held = heldCurrent(state_.time, state_.current, time, current, max_gap_);
  overpotential_ = step_.advance(overpotential_, held.current, held.duration);
  state_ = {time, overpotential_.value, current};
}

double StateTracker::expectedVoltage() const {
  return terminalVoltage(model_.parameters, state_.current, state_.u_c2);
}

FittedModel StateTracker::modelNow() const {
  FittedModel now = model_;
  now.state = state_;
  carryCovariance(now.covariance, overpotential_);
  return now;
}

void setStateFromVoltage(FittedModel& model, double time, double current, double voltage) {
  const BaseParameters& parameters = model.parameters;
  const double resistance = ohmicResistance(parameters, current);
  model.state = {time, voltage - parameters.u_dc - resistance * current, current};

  Eigen::RowVectorXd slope = Eigen::RowVectorXd::Zero(kCovarianceRows);
  slope[current < 0.0 ? kRowRDischarge : kRowRCharge] = -current;
  slope[kRowUDc] = -1.0;
  const Eigen::RowVectorXd shared = slope * model.covariance;
  const double own = std::pow(model.scores.rmse, 2);
  const double variance = shared.dot(slope) + own;
  model.covariance.row(kRowState) = shared;
  model.covariance.col(kRowState) = shared.transpose();
  model.covariance(kRowState, kRowState) = variance;
}

}  // namespace battery_sof
