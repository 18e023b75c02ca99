#include "prediction/stop_watch.hpp"

#include <cmath>

#include "prediction/prediction_interval.hpp"

namespace battery_sof {
namespace {

constexpr double kAges[] = {PastStop::kAge, 3.0 * PastStop::kAge};  // [s]

}  // namespace

std::optional<StopComparison> StopWatch::add(const StreamSample& sample, const StateTracker& before,
                                             double max_gap) {
  if (!before.hasSource()) return std::nullopt;
  const bool is_gap = sample.time - before.state().time > max_gap;
  const bool is_load = !is_gap && isStopLoad(sample.current, before.minCurrent());
  const bool begins = is_load && !was_load_;
  was_load_ = is_gap || is_load;
  if (!is_load) running_.reset();
  if (begins) {
    const FittedModel model = before.modelNow();
    running_.emplace(
        Stop{model, Follower(model, true), before.missed(), model.state.time, model.state.current});
  }
  if (!running_) return std::nullopt;
  Stop& stop = *running_;
  InputSample input;
  input.step = inputStep(stop.time, stop.current, sample.time, sample.current, max_gap);
  input.step.missed = stop.missed.add(input.step.duration, sample.current, false);
  input.voltage = sample.voltage;
  const FollowedSample followed = stop.follower.follow(input);
  stop.time = sample.time;
  stop.current = sample.current;
  if (stop.compared == std::size(kAges)) return std::nullopt;
  if (!stop.modelled && sample.time - stop.model.state.time >= kAges[stop.compared]) {
    stop.modelled = followed;
    stop.waits = stop.model.fit.voltage_lag + 1;
  }
  if (!stop.modelled || --stop.waits > 0) return std::nullopt;
  const StopComparison comparison = compare(sample.voltage);
  stop.modelled.reset();
  ++stop.compared;
  return comparison;
}

StopComparison StopWatch::compare(double voltage) const {
  const Stop& stop = *running_;
  StopComparison comparison;
  comparison.time = stop.model.state.time;
  comparison.duration = kAges[stop.compared];
  comparison.current = stop.modelled->current;
  comparison.measured_voltage = voltage;
  comparison.modelled_voltage = stop.modelled->voltage;
  const ErrorForecast error = ResidualFilter(stop.model).forecast(comparison.duration);
  const double value = stop.modelled->voltage + error.mean;
  const double half = kNinetyPercent * std::sqrt(stop.modelled->variance + error.variance);
  comparison.expected_voltage = {value, value - half, value + half};
  return comparison;
}

}  // namespace battery_sof
