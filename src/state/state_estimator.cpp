#include "state/state_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "model/input_sequence.hpp"
#include "recording/events.hpp"
#include "recording/voltage_repair.hpp"

namespace battery_sof {
namespace {

constexpr double kAverage = 0.1;  // [s], docs/physics.md#noise-of-a-residual
constexpr std::size_t kMinAverages = 30;
// Of a stop's voltage, about its mean so far (docs/decisions/0018-stops.md).
constexpr double kStopError = 0.05, kLeastStopError = 0.02;  // [V]
constexpr double kStopMemory = 5.0, kStopForgets = 8.0;      // [s]

}  // namespace

ResidualFilter::ResidualFilter(const FittedModel& model, bool follows_stops)
    : noise_(model.fit.noise),
      filter_(filterOf(model.fit.noise.value_or(NoiseModel{1.0, 0.0, 1.0, 0.0}))),
      drift_(model.state.residual_state.drift),
      colored_(model.state.residual_state.colored),
      next_stop_(model.intervals.event_history.nextStop(model.fit.scores.rmse)),
      present_(model),
      limits_{model.fit.crank_current} {
  const ResidualState& saved = model.state.residual_state;
  filter_.setVariances(saved.p_dd, saved.p_da, saved.p_aa);
  if (model.fit.source && follows_stops) min_current_ = model.fit.source->min_current;
}

void ResidualFilter::expectStop() {
  if (min_current_) setLevel(next_stop_);
}

void ResidualFilter::follow(const InputSample& sample, double error, double physics_error) {
  const double duration = sample.step.duration;
  present_.follow(sample, physics_error);
  if (!min_current_) return sample.voltage_controlled ? wait(duration) : update(duration, error);
  const bool in_stop =
      !sample.voltage_controlled && isStopLoad(sample.step.current, *min_current_, limits_);
  if (in_stop != in_stop_) setLevel(next_stop_);
  in_stop_ = in_stop;
  if (in_stop) updateInStop(duration, error);
}

void ResidualFilter::update(double duration, double error) {
  if (!noise_) return;
  const auto step = filter_.step(duration, 1.0, false);
  colored_ *= step.persistence;
  const double innovation = error - drift_ - colored_;
  drift_ += step.drift * innovation;
  colored_ += step.colored * innovation;
}

void ResidualFilter::wait(double duration) {
  if (noise_) colored_ *= filter_.wait(duration);
}

void ResidualFilter::setLevel(const ErrorForecast& level) {
  drift_ = level.mean;
  colored_ = 0.0;
  filter_.setVariances(level.variance, 0.0, 0.0);
}

void ResidualFilter::updateInStop(double duration, double error) {
  const double weight = duration / (kStopError * kStopError * kStopMemory);
  const double variance = 1.0 / (1.0 / std::max(filter_.p_dd(), 1e-6) + weight);
  drift_ +=
      std::max(variance * weight, 1.0 - std::exp(-duration / kStopForgets)) * (error - drift_);
  filter_.setVariances(std::max(variance, kLeastStopError * kLeastStopError), 0.0, 0.0);
}

ErrorForecast ResidualFilter::forecast(double ahead) const {
  // The spread from stop to stop holds what passes.
  if (min_current_)
    return {drift_, filter_.p_dd() + (noise_ ? std::pow(noise_->walk_std, 2) * ahead : 0.0)};
  NoiseFilter<double> later = filter_;
  const double persistence = later.wait(ahead);
  return {drift_ + persistence * colored_, later.variance()};
}

ErrorForecast ResidualFilter::forecastThrough(double ahead) const {
  const ErrorForecast all = forecast(ahead);
  if (min_current_) return {0.0, all.variance};
  const double left_out = all.mean - drift_;
  return noise_ ? ErrorForecast{drift_, all.variance + left_out * left_out} : all;
}

ResidualState ResidualFilter::residualState() const {
  return {drift_, colored_, filter_.p_dd(), filter_.p_da(), filter_.p_aa(), present_.state()};
}

namespace {

/// What a model missed of its window's voltage; nothing where the voltage drove. @param present
/// follows it.
std::vector<std::optional<double>> missedVoltage(const FittedModel& model, const Series& series,
                                                 IndexRange range, PresentErrorFilter& present) {
  if (model.fit.first_state.size() == 0 || range.empty()) return {};
  Simulation simulation = simulationOf(atFirstState(model));
  std::vector<std::optional<double>> missed;
  for (const InputSample& sample : inputsOf(model.fit, series, range).samples) {
    const double error = simulation.follow(sample);
    present.follow(sample, error);
    missed.push_back(sample.voltage_controlled ? std::nullopt : std::optional<double>(error));
  }
  return missed;
}

}  // namespace

void fitErrors(FittedModel& model, const Series& series, IndexRange range) {
  PresentErrorFilter present(model);
  const auto missed = missedVoltage(model, series, range, present);
  model.state.residual_state.present = present.state();
  const double interval = medianInterval(series);
  const auto each =
      static_cast<std::size_t>(std::max(1.0, std::round(kAverage / std::max(interval, 1e-6))));
  const Eigen::Map<const Eigen::VectorXd> time(series.time.data() + range.first,
                                               static_cast<Eigen::Index>(range.size()));
  const std::optional<NoiseModel> noise = fitNoiseToMeans(time, missed, each, kMinAverages);
  if (!noise) return;
  model.fit.noise = noise;
  model.state.residual_state = {
      0.0, 0.0, 0.0, 0.0, model.fit.noise->ar_std * model.fit.noise->ar_std, present.state()};
  ResidualFilter tracker(model);
  for (std::size_t n = 0; n < missed.size(); ++n) {
    const double duration =
        n == 0 ? 0.0 : series.time[range.first + n] - series.time[range.first + n - 1];
    missed[n] ? tracker.update(duration, *missed[n]) : tracker.wait(duration);
  }
  model.state.residual_state = tracker.residualState();
}

StateEstimator::StateEstimator(const FittedModel& model, bool uncertain)
    : simulation_(uncertain ? uncertainSimulationOf(model) : simulationOf(model)),
      residual_regression_(model.fit.residual_regression),
      state_(model.state),
      errors_(model),
      has_source_(model.fit.source) {
  // A source's ramp begins at the voltage that the state represents.
  simulation_.hold(state_.current, 0.0);
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
  state_.time = sample.step.time;
  state_.current = sample.step.current;
  state_.states = simulation_.state();
  return out;
}

FollowedSample StateEstimator::follow(const InputSample& sample) {
  FollowedSample followed = predict(sample);
  update(sample, sample.voltage - followed.voltage, followed.physics_error);
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
