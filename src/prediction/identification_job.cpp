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

/// IdentificationResult::worsening.
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
ModelMonitor followedBehind(const FittedModel& model, const IdentificationJob& job,
                            double max_gap) {
  ModelMonitor followed(job.events, job.steps);
  followed.install(model, max_gap);
  followed.lookBack(job.series);
  for (std::size_t n = firstAfter(job.series, model.state.time); n < job.series.size(); ++n)
    followed.follow(job.series[n], max_gap);
  return followed;
}

/// runIdentification() but for faults.
IdentificationResult attempt(const IdentificationJob& job) {
  const Series& series = job.series;
  IdentificationResult result;
  result.source = ChargerShare(series, detectControlMode(series, job.events));
  const WindowChoice choice = chooseWindow(series, {0, series.size()}, job.window_length);
  result.message = choice.message;
  if (!choice.range) return result;
  if (choice.excitation < job.min_window_quality) {
    result.message = "the quality of the best window, " + std::to_string(choice.excitation) +
                     ", is below the required " + std::to_string(job.min_window_quality);
    return result;
  }
  IdentifyOptions options = job.identify;
  takeInstrument(options, series, instrumentLimits(series));
  if (options.start != FitStart::kPaper)
    options.source = chargerControl(series, std::nullopt, job.events);
  options.chooses_effects = true;
  result.model = fitPlanned(series, {choice, options});
  result.message = result.model->fit.message;
  if (!isUsable(result.model->fit)) return result;
  const double max_gap = gapThreshold(series);
  result.followed = followedBehind(*result.model, job, max_gap);
  result.model = result.followed->now();
  const IndexRange recent =
      recentWindow(series, job.window_length.value_or(defaultWindowLength(series)));
  const auto errorsOf = [&](const FittedModel& model) {
    return openLoopErrors(drivenAs(model, result.model->fit), series, recent, max_gap,
                          options.masked);
  };
  const OpenLoopErrors errors = errorsOf(*result.model);
  result.recent_rmse = errors.voltage.rmse();
  result.recent_current_rmse = errors.current.rmse();
  if (!job.incumbent) return result;
  const OpenLoopErrors before = errorsOf(*job.incumbent);
  result.incumbent_rmse = before.voltage.rmse();
  result.incumbent_current_rmse = before.current.rmse();
  result.worsening = worseningOf(errors, before);
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
  try {
    return attempt(job);
  } catch (const std::exception& error) {
    IdentificationResult failed;
    failed.message = std::string("the identification failed: ") + error.what();
    return failed;
  }
}

}  // namespace battery_sof
