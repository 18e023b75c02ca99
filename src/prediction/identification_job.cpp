#include "prediction/identification_job.hpp"

#include <cmath>

#include "estimation/window.hpp"
#include "prediction/scores.hpp"
#include "recording/fit_mask.hpp"
#include "recording/voltage_repair.hpp"
#include "state/state_tracker.hpp"

namespace battery_sof {

namespace {

constexpr double kShareBlock = 10.0;  // [s], of a ChargerShare

/// Errors of one quantity over the samples in which it is not the input.
struct OpenLoopError {
  std::size_t samples = 0;
  double squares = 0.0;
  double rmse() const {
    return samples > 0 ? std::sqrt(squares / static_cast<double>(samples)) : 0.0;
  }
};

struct OpenLoopErrors {
  OpenLoopError voltage, current;  // [V], [A]
};

/// A model as another one is driven: by the voltage of its source, or by the current alone.
FittedModel drivenAs(FittedModel model, const Fit& other) {
  if (!other.source) return drivenByCurrent(std::move(model));
  model.fit.source = other.source;
  model.fit.voltage_lag = other.voltage_lag;
  return model;
}

/// @param masked one a sample of the series: those that are no measurement.
OpenLoopErrors openLoopErrors(FittedModel model, const Series& series, IndexRange range,
                              double max_gap, const std::vector<char>& masked) {
  const std::size_t first = range.first;
  const double voltage = model.fit.source ? repairedVoltage(series, first, model.fit.voltage_lag)
                                          : series.voltage[first];
  setStateFromVoltage(model, series.time[first], series.current[first], voltage);
  StateTracker tracker(model, max_gap);
  tracker.lookBack(series);
  OpenLoopErrors errors;
  std::size_t settled = first;
  for (std::size_t n = first + 1; n < range.last; ++n) {
    if (!tracker.follow(series.time[n], series.current[n], series.voltage[n])) continue;
    ++settled;
    if (masked[settled]) continue;
    const SettledSample& last = *tracker.last();
    OpenLoopError& error = last.voltage_controlled ? errors.current : errors.voltage;
    ++error.samples;
    error.squares +=
        std::pow(last.voltage_controlled ? series.current[settled] - last.current : last.error, 2);
  }
  return errors;
}

/// IdentificationTrial::worsening.
double worseningOf(const OpenLoopErrors& errors, const OpenLoopErrors& before) {
  const auto part = [](const OpenLoopError& now, const OpenLoopError& then, double negligible) {
    return static_cast<double>(now.samples) *
           std::log(std::max(now.rmse(), negligible) / std::max(then.rmse(), negligible));
  };
  const double all = static_cast<double>(errors.voltage.samples + errors.current.samples);
  return all > 0.0 ? std::exp((part(errors.voltage, before.voltage, kNegligibleVoltage) +
                               part(errors.current, before.current, kNegligibleCurrent)) /
                              all)
                   : 1.0;
}

/// A model as it follows what lies behind its window, with the events there.
ModelMonitor followedBehind(const FittedModel& model, const Series& series, ModelMonitor followed,
                            double max_gap) {
  followed.install(model, max_gap);
  followed.lookBack(series);
  for (std::size_t n = firstAfter(series, model.state.time); n < series.size(); ++n)
    followed.follow(series[n], max_gap);
  return followed;
}

/// What all fits of one job share.
struct JobWindow {
  WindowChoice choice;
  IndexRange recent;
  double max_gap;        // [s]
  ModelMonitor monitor;  // without a model
  InstrumentLimits limits;
  std::optional<ChargerControl> source;  // where it controls the voltage
};

IdentificationTrial tryFit(const Series& series, const JobWindow& window, IdentifyOptions options,
                           const std::optional<FittedModel>& incumbent) {
  IdentificationTrial trial;
  takeLimits(options, series, window.limits);
  if (options.start != FitStart::kPaper) options.source = window.source;
  options.chooses_effects = true;
  trial.model = fitPlanned(series, {window.choice, options});
  trial.message = trial.model->fit.message;
  if (!isUsable(trial.model->fit)) return trial;
  trial.followed = followedBehind(*trial.model, series, window.monitor, window.max_gap);
  trial.model = trial.followed->now();
  const auto errorsOf = [&](const FittedModel& model) {
    return openLoopErrors(drivenAs(model, trial.model->fit), series, window.recent, window.max_gap,
                          options.masked);
  };
  const OpenLoopErrors errors = errorsOf(*trial.model);
  trial.recent_rmse = errors.voltage.rmse();
  trial.recent_current_rmse = errors.current.rmse();
  if (!incumbent) return trial;
  const OpenLoopErrors before = errorsOf(*incumbent);
  trial.incumbent_rmse = before.voltage.rmse();
  trial.incumbent_current_rmse = before.current.rmse();
  trial.worsening = worseningOf(errors, before);
  return trial;
}

/// runIdentification() but for faults and the epoch.
IdentificationResult attempt(const IdentificationJob& job) {
  IdentificationResult result;
  result.max_gap = gapThreshold(job.series);
  result.source = ChargerShare(job.series, detectControlMode(job.series, job.events));
  const WindowChoice choice = chooseWindow(job.series, {0, job.series.size()}, job.window_length);
  result.message = choice.message;
  if (!choice.range) return result;
  if (choice.excitation < job.min_window_quality) {
    result.message = "the quality of the best window, " + std::to_string(choice.excitation) +
                     ", is below the required " + std::to_string(job.min_window_quality);
    return result;
  }
  const JobWindow window{
      choice,
      recentWindow(job.series, job.window_length.value_or(defaultWindowLength(job.series))),
      result.max_gap,
      ModelMonitor(job.events, job.steps),
      instrumentLimits(job.series),
      chargerControl(job.series, std::nullopt, job.events)};
  static_cast<IdentificationTrial&>(result) =
      tryFit(job.series, window, job.identify, job.incumbent);
  return result;
}

}  // namespace

ChargerShare::ChargerShare(const ControlModeRule& rule)
    : seen_(rule.present), watch_(ControlModeDetector(rule)) {}

ChargerShare::ChargerShare(const Series& series, const ControlModes& source)
    : seen_(source.seen), watch_(ControlModeDetector(source.rule)) {
  for (std::size_t n = 0; n < series.size(); ++n) {
    if (series.time[n] >= series.time.back() - kControlModeLookBack)
      watch_->add(series.time[n], series.current[n], series.voltage[n]);
    count(series.time[n], source.voltage_controlled[n]);
  }
}

void ChargerShare::add(const Sample& sample) {
  if (watch_) count(sample.time, watch_->add(sample.time, sample.current, sample.voltage));
}

void ChargerShare::count(double time, bool controlled) {
  if (blocks_.empty() || time - blocks_.back().from > kShareBlock)
    blocks_.push_back({time, time, 0, 0});
  Block& block = blocks_.back();
  block.to = time;
  ++block.samples;
  if (controlled) ++block.controlled;
}

void ChargerShare::forgetBefore(double time) {
  while (!blocks_.empty() && blocks_.front().to < time) blocks_.pop_front();
}

void ChargerShare::forgetPast() { blocks_.clear(); }

std::optional<double> ChargerShare::share() const {
  std::size_t samples = 0, controlled = 0;
  for (const Block& block : blocks_) {
    samples += block.samples;
    controlled += block.controlled;
  }
  if (samples == 0) return std::nullopt;
  return static_cast<double>(controlled) / static_cast<double>(samples);
}

std::optional<double> ChargerShare::until() const {
  return blocks_.empty() ? std::nullopt : std::optional<double>(blocks_.back().to);
}

IndexRange recentWindow(const Series& series, double length) {
  if (series.empty()) return {};
  IndexRange recent = contiguousRanges(series, gapThreshold(series)).back();
  const double from = series.time.back() - length;
  while (series.time[recent.first] < from) ++recent.first;
  return recent;
}

IdentificationResult runIdentification(const IdentificationJob& job) {
  IdentificationResult result;
  try {
    result = attempt(job);
  } catch (const std::exception& error) {
    result.message = std::string("the identification failed: ") + error.what();
  }
  result.epoch = job.epoch;
  return result;
}

}  // namespace battery_sof
