#include "prediction/sample_stream.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "util/text.hpp"

namespace battery_sof {

namespace {

constexpr double kProbeDuration = 1.0;    // [s]
constexpr std::size_t kProbeSamples = 6;  // five intervals: their median survives two odd ones
constexpr double kDecimateAbove = 200.0;  // [Hz], twice the design rate of 100 Hz (Decimator)
// the past is cut in blocks, which makes a sample's cost constant
constexpr double kSlack = 1.25;

std::ptrdiff_t countBefore(const std::vector<double>& times, double time) {
  return std::lower_bound(times.begin(), times.end(), time) - times.begin();
}

/// Whether a sample was refused for what it measures, at a stamp that is a time.
bool areValuesRefused(SampleFate fate, const RawSample& sample) {
  const bool is_of_values = fate == SampleFate::kMissingValue || fate == SampleFate::kNotFinite ||
                            fate == SampleFate::kOutOfRange;
  return is_of_values && std::abs(sample.time) <= IntakeLimits::kMaxAbsTime;
}

}  // namespace

SampleStream::SampleStream(double kept, const StreamBattery& battery)
    : kept_(kept), watch_(battery) {
  requireThat(kept > 0.0, "kept [s]", kept, "above 0");
}

std::string reasonsOf(const StreamCounts& counts) {
  std::string reasons = reasonsOf(counts.rejected);
  if (counts.stamp_ahead > 0)
    reasons += (reasons.empty() ? "" : ", ") + countsText({{counts.stamp_ahead, "stamp ahead"}});
  return reasons;
}

std::string toString(const StreamCounts& counts) {
  const std::string reasons = reasonsOf(counts);
  return format("%zu rejected", counts.rejectedTotal()) +
         (reasons.empty() ? "" : " (" + reasons + ")");
}

StreamCounts SampleStream::counts() const {
  StreamCounts counts = counts_;
  counts.rejected = intake_.rejected();
  counts.rejected_temperatures = intake_.rejectedTemperatures();
  return counts;
}

std::vector<Sample> SampleStream::push(const RawSample& sample) {
  std::vector<Sample> added;
  if (const std::optional<RawSample> first = jumpConfirmedBy(sample)) {
    held_.reset();
    if (first->time < *newest_) restart();
    enter(*first, added);
    enter(sample, added);
    return added;
  }
  dropHeld();
  if (isSuspicious(sample.time))
    held_ = sample;
  else
    enter(sample, added);
  return added;
}

std::optional<RawSample> SampleStream::jumpConfirmedBy(const RawSample& sample) const {
  const bool confirms = isSuspicious(sample.time) && held_ && sample.time > held_->time &&
                        sample.time <= held_->time + kClockAhead;
  return confirms ? held_ : std::nullopt;
}

void SampleStream::resumeAfter(const SampleStream& since) {
  counts_ = since.counts_;
  ++counts_.clock_restarts;
  intake_ = since.intake_;
  intake_.resumeAt(newest_);
  watch_ = since.watch_;
  watch_.forgetClock();
  held_.reset();
}

bool SampleStream::isSuspicious(double time) const {
  // the intake refuses the rest, and says why
  const bool is_time = std::abs(time) <= IntakeLimits::kMaxAbsTime;
  return newest_ && is_time && (time < *newest_ - kClockBack || time > *newest_ + kClockAhead);
}

void SampleStream::dropHeld() {
  if (!held_) return;
  if (held_->time > *newest_) {
    ++counts_.stamp_ahead;
  } else {
    intake_.judge(*held_);
  }
  held_.reset();
}

void SampleStream::restart() {
  ++counts_.clock_restarts;
  intake_.forgetClock();
  watch_.forgetClock();
  newest_.reset();
  probe_ = {};
  input_rate_.reset();
  decimator_.reset();
  series_ = {};
}

void SampleStream::enter(const RawSample& sample, std::vector<Sample>& added) {
  const SampleFate fate = intake_.judge(sample);
  const bool accepted = fate == SampleFate::kAccepted;
  if (!accepted && fate != SampleFate::kTemperatureOnly) {
    if (areValuesRefused(fate, sample)) watch_.refuse(sample.time, max_gap_);
    return;
  }
  auto& times = series_.temperature_time;
  if (sample.temperature && isTemperature(*sample.temperature) &&
      (times.empty() || sample.time > times.back())) {
    times.push_back(sample.time);
    series_.temperature.push_back(*sample.temperature);
  }
  if (!accepted) return;
  ++counts_.accepted;
  newest_ = sample.time;
  watch_.accept({sample.time, sample.current, sample.voltage}, max_gap_);
  probe({sample.time, sample.current, sample.voltage}, added);
}

void SampleStream::probe(const Sample& sample, std::vector<Sample>& added) {
  if (input_rate_) return emit(sample, added);
  probe_.append(sample);
  const double span = probe_.time.back() - probe_.time.front();
  if (probe_.size() < kProbeSamples || span < kProbeDuration) return;
  input_rate_ = 1.0 / medianInterval(probe_);
  max_gap_ = gapThreshold(probe_);
  if (*input_rate_ > kDecimateAbove) decimator_.emplace(*input_rate_);
  for (std::size_t n = 0; n < probe_.size(); ++n) emit(probe_[n], added);
  probe_ = {};
}

void SampleStream::emit(const Sample& sample, std::vector<Sample>& added) {
  for (const Sample& due : decimator_ ? decimator_->push(sample) : std::vector<Sample>{sample}) {
    added.push_back(due);
    series_.append(due);
  }
  forgetOld();
  watch_.look(series_, max_gap_);
}

void SampleStream::forgetOld() {
  if (series_.empty() || series_.time.back() - series_.time.front() <= kSlack * kept_) return;
  const double from = series_.time.back() - kept_;
  series_.dropFirst(static_cast<std::size_t>(countBefore(series_.time, from)));
  const std::ptrdiff_t temperatures = countBefore(series_.temperature_time, from);
  for (auto* values : {&series_.temperature_time, &series_.temperature})
    values->erase(values->begin(), values->begin() + temperatures);
}

}  // namespace battery_sof
