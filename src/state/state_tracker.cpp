#include "state/state_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "recording/events.hpp"
#include "recording/voltage_repair.hpp"

namespace battery_sof {
namespace {

// How long an error stays what it is: a crank's, and a fitted model's [s].
constexpr double kCrankMemory = 1.0;
constexpr double kModelMemory = 30.0;
constexpr double kLearnInterval = 0.1;  // [s]
constexpr double kMostRested = 12.9;    // [V] of a block: above it a charger holds the voltage
constexpr double kLeastVoltageError = 0.02, kLeastCurrentError = 0.5;  // [V], [A]
constexpr double kUsualCurrentError = 3.0;                             // [A], where no window says
constexpr double kRestError = 0.1;  // [V], by which a rested battery's voltage may differ

constexpr double kTraceKept = 1.0;  // [s], far more than any shift between channels

bool isCrank(const InputSample& sample, const Fit& fit) {
  return sample.step.current < fit.crank_current;
}

/// The battery's own current: more than a vehicle's consumers draw [A].
double ownCurrent(const Fit& fit) { return EventLimits{fit.crank_current}.aboveConsumers(); }

}  // namespace

StateTracker::StateTracker(const FittedModel& model, double max_gap, bool follows_errors)
    : model_(model),
      max_gap_(max_gap),
      follows_errors_(follows_errors),
      settled_(model),
      needs_trace_(!model.fit.effects.empty()) {
  if (model.fit.source) watch_.emplace(*model.fit.source);
  if (needs_trace_) trace_.append(model.state.time, model.state.current, max_gap_);
}

void StateTracker::lookBack(const Series& series) {
  if (!watch_) return;
  const IndexRange past = indexRange(series, state().time - kControlModeLookBack, state().time);
  for (std::size_t n = past.first; n < past.last; ++n) {
    recent_ = slice(series, {n, n + 1});
    controlled_ = {
        static_cast<char>(watch_->add(series.time[n], series.current[n], series.voltage[n]))};
    settled_count_ = 1;
  }
}

bool StateTracker::follow(double time, double current, double voltage) {
  if (!(time > state().time))
    throw std::invalid_argument("StateTracker: time " + std::to_string(time) +
                                " s is not after the state's " + std::to_string(state().time) +
                                " s");
  if (needs_trace_) trace_.append(time, current, max_gap_);
  recent_.append({time, current, voltage});
  voltage_controlled_ = watch_ && watch_->add(time, current, voltage);
  controlled_.push_back(voltage_controlled_);
  const std::size_t behind = watch_ ? model_.fit.voltage_lag + 1 : 0;
  const bool settles = recent_.size() - settled_count_ > behind;
  if (settles) settleOldest();
  if (watch_) lookAhead();
  return settles;
}

void StateTracker::settleOldest() {
  const std::size_t oldest = settled_count_;
  const InputSample sample = sampleAfter(settled_, oldest);
  const FollowedSample followed = settled_.predict(sample);
  const std::optional<double> left = learns_ ? learnFromSettled(sample, followed) : std::nullopt;
  const double error = sample.voltage - followed.voltage, remaining = left.value_or(error);
  settled_.update(sample, remaining, followed.physics_error + remaining - error);
  last_ = SettledSample{followed, settled_.state().time, sample.voltage,
                        sample.voltage_controlled
                            ? kOhmsOfCurrentError * (sample.step.current - followed.current)
                            : sample.voltage - followed.voltage};
  if (needs_trace_) trace_.forgetBefore(settled_.state().time - kTraceKept);
  recent_.dropFirst(oldest);
  controlled_.erase(controlled_.begin(), controlled_.begin() + oldest);
  settled_count_ = 1;
}

Innovation StateTracker::innovationOf(const InputSample& sample,
                                      const FollowedSample& followed) const {
  const Simulation& simulation = settled_.simulation();
  const Fit& fit = model_.fit;
  const Eigen::MatrixXd& begun = simulation.seeds();
  Innovation innovation;
  innovation.factor.resize(begun.rows(), begun.cols());
  const Eigen::MatrixXd states = simulation.stateDerivatives();
  innovation.factor << begun.topRows(begun.rows() - states.rows()), states;
  const bool is_crank = isCrank(sample, fit);
  if (sample.voltage_controlled) {
    innovation.error = sample.step.current - followed.current;
    innovation.modelled = -simulation.currentErrorDerivatives();
    innovation.std_error =
        std::max(fit.scores.current_rmse.value_or(kUsualCurrentError), kLeastCurrentError);
  } else {
    innovation.error = sample.voltage - followed.voltage;
    innovation.modelled = simulation.voltageDerivatives();
    innovation.std_error = std::max(
        {fit.scores.rmse, is_crank ? fit.scores.crank_error_std : 0.0, kLeastVoltageError});
  }
  // Where nothing was fitted, a charger may control what looks like a battery's answer: only a large
  // discharge is the battery's own.
  if (fit.window.samples == 0 && sample.step.current > ownCurrent(fit))
    innovation.rows = {sample.step.current > 0.0 ? kRowRCharge : kRowUDc};
  if (!last_) return innovation;
  // Errors of samples next to each other are one error: a fitted model's stay, those of the
  // population are its parameters' and are taken in.
  const double memory = is_crank || fit.window.samples == 0 ? kCrankMemory : kModelMemory;
  const double since = sample.step.time - std::max(learnt_until_, sample.step.time - memory);
  innovation.std_error *= std::sqrt(std::max(1.0, memory / std::max(since, kLearnInterval)));
  return innovation;
}

std::optional<double> StateTracker::learnFromSettled(const InputSample& sample,
                                                     const FollowedSample& followed) {
  Fit& fit = model_.fit;
  ExcitedRange& seen = fit.excited;
  seen.min_current = std::min(seen.min_current, sample.step.current);
  seen.max_current = std::max(seen.max_current, sample.step.current);
  seen.min_voltage = std::min(seen.min_voltage, sample.voltage);
  seen.max_voltage = std::max(seen.max_voltage, sample.voltage);
  const double time = settled_.state().time, current = sample.step.current;
  if (time - learnt_until_ < kLearnInterval) return std::nullopt;
  const bool is_held = current <= 0.0 && current > ownCurrent(fit) && sample.voltage > kMostRested;
  if (fit.window.samples == 0 && is_held) return std::nullopt;
  const Innovation innovation = innovationOf(sample, followed);
  const double surprise = innovation.error / std::hypot(innovation.modelled.norm(),
                                                        std::max(innovation.std_error, kRestError));
  if (!std::isfinite(surprise)) return std::nullopt;
  if (!last_ || isCrank(sample, fit)) {
    if (!sample.voltage_controlled && (!last_ || time - cranked_ > kCrankMemory))
      surprise_.add(surprise);
    if (last_) cranked_ = time;
  }
  FittedModel now = modelAt(settled_);
  const double left = takeIn(now, innovation);
  learnt_until_ = time;
  model_ = std::move(now);
  const ResidualFilter errors = settled_.errors();
  settled_ = StateEstimator(model_);
  settled_.errors() = errors;
  return left;
}

void StateTracker::lookAhead() {
  ahead_.emplace(settled_);
  for (std::size_t n = settled_count_; n < recent_.size(); ++n)
    ahead_->follow(sampleAfter(*ahead_, n));
}

/// The n-th of the recent samples as the input of a state that stands at the one before.
InputSample StateTracker::sampleAfter(const StateEstimator& estimator, std::size_t n) const {
  InputSample sample{
      estimator.stepTo(recent_.time[n], recent_.current[n], max_gap_),
      watch_ ? repairedVoltage(recent_, n, model_.fit.voltage_lag) : recent_.voltage[n], 1.0,
      controlled_[n] != 0};
  if (needs_trace_) sample.step.trace = &trace_;
  return sample;
}

void StateTracker::setKnown(const FittedModel& model) {
  model_.provenance = model.provenance;
  model_.fit.excited = model.fit.excited;
  model_.fit.scores = model.fit.scores;
}

FittedModel StateTracker::modelAt(const StateEstimator& estimator) const {
  FittedModel now = model_;
  estimator.saveTo(now);
  if (!follows_errors_) now.state.residual_state = {};
  return now;
}

void setStateFromVoltage(FittedModel& model, double time, double current, double voltage) {
  const BatteryModel composition = compositionOf(model.fit);
  model.state.time = time;
  model.state.current = current;
  model.state.missed_crank = {};
  model.state.residual_state.present.current.reset();
  Simulation here = uncertainSimulationOf(model);
  here.hold(current, 0.0);
  const double missing = voltage - here.voltage();

  const Eigen::Index parameters = composition.parameterCount();
  const Eigen::MatrixXd& factor = here.seeds();
  const double own = std::pow(model.fit.scores.rmse, 2);
  Eigen::MatrixXd moved = factor;
  Eigen::VectorXd unshared = Eigen::VectorXd::Zero(factor.rows());
  for (Eigen::Index j = 0; j < composition.stateCount(); ++j) {
    if (j > 0 && !composition.states()[j].begins_as_u_c2) continue;
    // du/du_c2 is one, so what the voltage leaves open apart from u_c2 is what u_c2 takes over.
    model.state.states[j] += missing;
    if (factor.cols() > 0)
      moved.row(parameters + j) = factor.row(parameters) - here.voltageDerivatives().transpose();
    unshared[parameters + j] = std::sqrt(own);
  }
  model.fit.covariance = moved * moved.transpose() + unshared * unshared.transpose();
}

}  // namespace battery_sof
