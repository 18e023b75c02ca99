#include "battery_sof/intake.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <utility>

#include "battery_sof/sample_list.hpp"
#include "util/constants.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

bool isTemperatureAlone(const RawSample& sample) {
  return std::isnan(sample.current) && std::isnan(sample.voltage) && sample.temperature &&
         !std::isnan(*sample.temperature);
}

void appendTemperature(Series& series, const RawSample& sample) {
  if (!sample.temperature || !isTemperature(*sample.temperature)) return;
  if (!series.temperature_time.empty() && sample.time <= series.temperature_time.back()) return;
  series.temperature_time.push_back(sample.time);
  series.temperature.push_back(*sample.temperature);
}

void appendSample(Series& series, const RawSample& sample) {
  if (!series.empty() && sample.time <= series.time.back())
    throw std::invalid_argument("append: time " + std::to_string(sample.time) +
                                " s is not after the recording's last sample at " +
                                std::to_string(series.time.back()) +
                                " s; the intake and the recording do not belong together");
  series.append({sample.time, sample.current, sample.voltage});
  appendTemperature(series, sample);
}

/// @param values each with its largest magnitude.
SampleFate judgeValues(std::initializer_list<std::pair<double, double>> values) {
  const auto any = [&values](auto is_fault) {
    return std::any_of(values.begin(), values.end(), is_fault);
  };
  if (any([](const auto& value) { return std::isnan(value.first); }))
    return SampleFate::kMissingValue;
  if (any([](const auto& value) { return std::isinf(value.first); })) return SampleFate::kNotFinite;
  return any([](const auto& value) { return std::abs(value.first) > value.second; })
             ? SampleFate::kOutOfRange
             : SampleFate::kAccepted;
}

}  // namespace

std::string reasonsOf(const RejectedCounts& rejected) {
  return countsText({{rejected.missing_value, "missing value"},
                     {rejected.not_finite, "not finite"},
                     {rejected.duplicate_stamp, "duplicate stamp"},
                     {rejected.clock_step_back, "clock step back"},
                     {rejected.out_of_range, "out of range"}});
}

std::string toString(const RejectedCounts& rejected) {
  const std::string reasons = reasonsOf(rejected);
  return std::to_string(rejected.total()) + " rejected" +
         (reasons.empty() ? "" : " (" + reasons + ")");
}

SampleFate Intake::judge(const RawSample& sample) {
  const bool temperature_alone = isTemperatureAlone(sample);
  std::optional<double>& last = temperature_alone ? last_temperature_time_ : last_time_;
  constexpr double kMaxTime = IntakeLimits::kMaxAbsTime;
  SampleFate fate = temperature_alone
                        ? judgeValues({{sample.time, kMaxTime}})
                        : judgeValues({{sample.time, kMaxTime},
                                       {sample.current, IntakeLimits::kMaxAbsCurrent},
                                       {sample.voltage, IntakeLimits::kMaxAbsVoltage}});
  if (fate == SampleFate::kAccepted) fate = judgeOrder(sample.time, last);
  count(fate);
  if (fate != SampleFate::kAccepted) return fate;
  countTemperature(sample);
  last = sample.time;
  return temperature_alone ? SampleFate::kTemperatureOnly : SampleFate::kAccepted;
}

SampleFate Intake::judgeOrder(double time, const std::optional<double>& last) {
  if (!last || time - *last >= IntakeLimits::kMinInterval) return SampleFate::kAccepted;
  if (time >= *last) return SampleFate::kDuplicateStamp;
  largest_step_back_ = std::max(largest_step_back_, *last - time);
  return SampleFate::kClockStepBack;
}

void Intake::count(SampleFate fate) {
  if (fate == SampleFate::kMissingValue) ++rejected_.missing_value;
  if (fate == SampleFate::kNotFinite) ++rejected_.not_finite;
  if (fate == SampleFate::kDuplicateStamp) ++rejected_.duplicate_stamp;
  if (fate == SampleFate::kClockStepBack) ++rejected_.clock_step_back;
  if (fate == SampleFate::kOutOfRange) ++rejected_.out_of_range;
}

void Intake::countTemperature(const RawSample& sample) {
  const std::optional<double>& temperature = sample.temperature;
  if (temperature && !std::isnan(*temperature) && !isTemperature(*temperature))
    ++rejected_temperatures_;
}

void Intake::resumeAt(const std::optional<double>& time) {
  last_time_ = time;
  last_temperature_time_.reset();
}

SampleFate append(Recording& recording, Intake& intake, const RawSample& sample) {
  const SampleFate fate = intake.judge(sample);
  if (fate == SampleFate::kAccepted) appendSample(recording.series, sample);
  if (fate == SampleFate::kTemperatureOnly) {
    appendTemperature(recording.series, sample);
  } else {
    ++recording.offered;
  }
  recording.rejected = intake.rejected();
  recording.rejected_temperatures = intake.rejectedTemperatures();
  recording.largest_step_back = intake.largestStepBack();
  return fate;
}

Recording recordingOf(const std::string& name, const std::vector<RawSample>& samples) {
  if (samples.empty()) throw RecordingError(name + ": has no sample, expected at least one");
  Recording recording;
  recording.name = printable(name);
  Intake intake;
  for (const RawSample& sample : samples) append(recording, intake, sample);
  requireUsable(name, recording);
  return recording;
}

std::vector<RawSample> rawSamplesOf(const Series& series) {
  std::vector<RawSample> samples;
  samples.reserve(series.size());
  std::size_t next = 0;
  const auto temperatures_before = [&](double time) {
    for (; next < series.temperature.size() && series.temperature_time[next] < time; ++next)
      samples.push_back({series.temperature_time[next], kNan, kNan, series.temperature[next]});
  };
  for (std::size_t n = 0; n < series.size(); ++n) {
    temperatures_before(series.time[n]);
    std::optional<double> temperature;
    if (next < series.temperature.size() && series.temperature_time[next] == series.time[n])
      temperature = series.temperature[next++];
    samples.push_back({series.time[n], series.current[n], series.voltage[n], temperature});
  }
  temperatures_before(std::numeric_limits<double>::infinity());
  return samples;
}

void requireUsable(const std::string& name, const Recording& recording) {
  constexpr double kUnsortedShare = 0.1;  // more clock steps back than this are not a clock's
  const RejectedCounts& rejected = recording.rejected;
  if (rejected.clock_step_back > kUnsortedShare * recording.offered)
    throw RecordingError(name +
                         ": is not sorted by time: " + std::to_string(rejected.clock_step_back) +
                         " of " + std::to_string(recording.offered) + " samples go back in time");
  if (recording.series.empty())
    throw RecordingError(name + ": holds no usable sample: of " +
                         std::to_string(recording.offered) + ", " +
                         std::to_string(rejected.missing_value) + " lack a value, " +
                         std::to_string(rejected.not_finite) + " are not finite, " +
                         std::to_string(rejected.out_of_range) + " are out of range");
}

}  // namespace battery_sof
