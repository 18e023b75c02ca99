#include "model/input_sequence.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "recording/channel_statistics.hpp"
#include "recording/events.hpp"

namespace battery_sof {

CurrentTrace::CurrentTrace(const Series& series, IndexRange range, double max_gap) {
  samples_.reserve(range.size());
  for (std::size_t n = range.first; n < range.last; ++n)
    append(series.time[n], series.current[n], max_gap);
}

void CurrentTrace::append(double time, double current, double max_gap) {
  Sample sample{time, current, 0.0, false};
  if (!samples_.empty()) {
    const Sample& before = samples_.back();
    sample.gap = time - before.time > max_gap;
    const double mean = sample.gap ? 0.0 : 0.5 * (before.current + current);
    sample.charge = before.charge + mean * (time - before.time);
  }
  samples_.push_back(sample);
}

void CurrentTrace::forgetBefore(double time) {
  const auto after =
      std::upper_bound(samples_.begin(), samples_.end(), time,
                       [](double t, const Sample& sample) { return t < sample.time; });
  // Erased in bulk, so that forgetting costs nothing per sample.
  if (after - samples_.begin() >= 2048) samples_.erase(samples_.begin(), after - 1);
}

const CurrentTrace::Sample* CurrentTrace::endOfSegment(double time) const {
  return &*std::lower_bound(samples_.begin() + 1, samples_.end() - 1, time,
                            [](const Sample& sample, double t) { return sample.time < t; });
}

double CurrentTrace::at(double time) const {
  if (samples_.empty()) return 0.0;
  if (time <= samples_.front().time) return samples_.front().current;
  if (time >= samples_.back().time) return samples_.back().current;
  const Sample* const end = endOfSegment(time);
  if (end->gap && time < end->time) return 0.0;
  const Sample& begin = end[-1];
  const double share = (time - begin.time) / (end->time - begin.time);
  return begin.current + share * (end->current - begin.current);
}

double CurrentTrace::slopeAt(double time) const {
  if (samples_.size() < 2 || time <= samples_.front().time || time > samples_.back().time)
    return 0.0;
  const Sample* const end = endOfSegment(time);
  const Sample& begin = end[-1];
  return end->gap ? 0.0 : (end->current - begin.current) / (end->time - begin.time);
}

double CurrentTrace::chargeUntil(double time) const {
  const Sample &first = samples_.front(), &last = samples_.back();
  if (time <= first.time) return (time - first.time) * first.current;
  if (time >= last.time) return last.charge + (time - last.time) * last.current;
  const Sample* const end = endOfSegment(time);
  const Sample& begin = end[-1];
  if (end->gap) return begin.charge;
  return begin.charge + 0.5 * (begin.current + at(time)) * (time - begin.time);
}

double CurrentTrace::meanBetween(double from, double to) const {
  if (samples_.empty()) return 0.0;
  return (chargeUntil(to) - chargeUntil(from)) / (to - from);
}

double meanSpan(double first_time, double last_time, std::size_t samples) {
  if (samples < 2) return 0.0;
  const auto count = static_cast<double>(samples);
  return (last_time - first_time) * count / (count - 1.0);
}

InputStep inputStep(double time_before, double current_before, double time, double current,
                    double max_gap) {
  const HeldCurrent held = heldCurrent(time_before, current_before, time, current, max_gap);
  const bool gap = held.duration > max_gap;
  const double slope =
      gap || held.duration <= 0.0 ? 0.0 : (current - current_before) / held.duration;
  return {time, held.duration, held.current, current, slope, 0.0, gap};
}

int InputStep::rampPieces() const {
  constexpr double kBend = 0.03;  // k [1/(A^2 s^2)]
  constexpr double kMost = 16.0;
  // parts of the shortest of numbers are nothing
  if (duration < kShortestStep) return 1;
  const double change = std::abs(slope) * duration,
               largest = std::max(std::abs(current), std::abs(current - slope * duration));
  return static_cast<int>(
      std::clamp(std::round(duration * std::sqrt(kBend * change * largest)), 1.0, kMost));
}

double MissedCrank::add(double duration, double current, bool voltage_controlled) {
  constexpr double kLongest = 2.0;  // [s], a longer interval says nothing of what flowed
  if (!voltage_controlled) {
    const double charge = std::max(-current, 0.0) * std::min(duration, kLongest);
    drawn_ += charge;
    if (current < EventLimits{}.engineTurns()) seen_ += charge;
    return 0.0;
  }
  const bool started = drawn_ >= kCharge && duration > kSlowestSeen;
  const double missed = started ? std::max(0.0, kCharge - seen_) : 0.0;
  drawn_ = seen_ = 0.0;
  return missed;
}

InputSequence inputSequence(const Series& series, IndexRange range, const std::vector<char>& masked,
                            const std::vector<char>& voltage_controlled) {
  InputSequence inputs;
  if (range.empty()) return inputs;
  const double max_gap = gapThreshold(series);
  inputs.trace = std::make_shared<CurrentTrace>(series, range, max_gap);
  inputs.first_time = series.time[range.first];
  inputs.samples.reserve(range.size());
  MissedCrank missed;
  for (std::size_t n = range.first; n < range.last; ++n) {
    InputSample sample;
    const std::size_t before = n > range.first ? n - 1 : n;
    sample.step = inputStep(series.time[before], series.current[before], series.time[n],
                            series.current[n], max_gap);
    sample.step.trace = inputs.trace.get();
    sample.voltage = series.voltage[n];
    if (!masked.empty() && masked[n]) sample.count = 0.0;
    sample.voltage_controlled = !voltage_controlled.empty() && voltage_controlled[n];
    if (!voltage_controlled.empty())
      sample.step.missed =
          missed.add(sample.step.duration, series.current[n], sample.voltage_controlled);
    inputs.samples.push_back(sample);
  }
  return inputs;
}

namespace {

/// Cuts a range into stretches that may be averaged, first to last.
class Stretches {
 public:
  Stretches(const Series& series, IndexRange range, double longest, double max_gap,
            const std::vector<char>& masked)
      : series_(series), range_(range), longest_(longest), max_gap_(max_gap), masked_(masked) {}

  /// @return one past the last sample of the stretch that begins at `first`.
  std::size_t endOf(std::size_t first) {
    if (first == range_.first || isEdge(first)) last_edge_ = series_.time[first];
    const double length = std::min(longest_, kGrowth * (series_.time[first] - last_edge_));
    double low = series_.current[first], high = low;
    std::size_t end = first + 1;
    while (end < range_.last && series_.time[end] - series_.time[first] <= length && !isEdge(end)) {
      low = std::min(low, series_.current[end]);
      high = std::max(high, series_.current[end]);
      if (high - low > kEdgeCurrent || (low < 0.0) != (high < 0.0)) break;
      ++end;
    }
    return endBeforeNextEdge(first, end);
  }

 private:
  static constexpr double kEdgeCurrent = 2.0;  // [A], a change by more ends a stretch
  // [1], a stretch is at most this share of the time since the last edge
  static constexpr double kGrowth = 0.25;

  /// A sample whose current stands away from the one before, that follows a gap, or that is masked
  /// or follows such a one.
  bool isEdge(std::size_t n) const {
    return std::abs(series_.current[n] - series_.current[n - 1]) > kEdgeCurrent ||
           series_.time[n] - series_.time[n - 1] > max_gap_ || isMasked(n) || isMasked(n - 1);
  }
  bool isMasked(std::size_t n) const { return !masked_.empty() && masked_[n]; }
  /// The samples just before an edge stay at full rate: shifted channels show there too.
  std::size_t endBeforeNextEdge(std::size_t first, std::size_t end) const {
    constexpr std::size_t kGuard = 5;
    for (std::size_t n = end; n < std::min(end + kGuard, range_.last); ++n)
      if (isEdge(n)) return std::max(first + 1, n > first + kGuard ? n - kGuard : first + 1);
    return end;
  }

  const Series& series_;
  IndexRange range_;
  double longest_, max_gap_;
  const std::vector<char>& masked_;
  double last_edge_ = 0.0;
};

/// Mean over a stretch. The state in its middle represents the state's mean.
struct Stretch {
  std::size_t first, last;
  double middle = 0.0, current = 0.0, voltage = 0.0;
};

Stretch stretchOf(const Series& series, std::size_t first, std::size_t last) {
  Stretch stretch{first, last};
  for (std::size_t n = first; n < last; ++n) {
    stretch.current += series.current[n];
    stretch.voltage += series.voltage[n];
  }
  const double count = static_cast<double>(last - first);
  stretch.current /= count;
  stretch.voltage /= count;
  stretch.middle = 0.5 * (series.time[first] + series.time[last - 1]);
  return stretch;
}

}  // namespace

double medianDuration(const InputSequence& inputs) {
  std::vector<double> durations;
  for (std::size_t n = 1; n < inputs.samples.size(); ++n)
    durations.push_back(inputs.samples[n].step.duration);
  return durations.empty() ? 1.0 : std::max(quantile(std::move(durations), 0.5), kShortestStep);
}

InputSequence compressedInputs(const Series& series, IndexRange range, double longest,
                               const std::vector<char>& masked) {
  InputSequence inputs;
  if (range.empty()) return inputs;
  const double max_gap = gapThreshold(series);
  inputs.trace = std::make_shared<CurrentTrace>(series, range, max_gap);
  inputs.first_time = series.time[range.first];
  Stretches stretches(series, range, longest, max_gap, masked);
  Stretch before{range.first, range.first};
  for (std::size_t first = range.first; first < range.last; first = before.last) {
    const Stretch now = stretchOf(series, first, stretches.endOf(first));
    InputSample sample;
    sample.step.time = now.middle;
    sample.step.current = now.current;
    sample.step.span =
        meanSpan(series.time[now.first], series.time[now.last - 1], now.last - now.first);
    sample.step.trace = inputs.trace.get();
    if (first > range.first) {
      sample.step.duration = now.middle - before.middle;
      sample.step.gap = series.time[first] - series.time[first - 1] > max_gap;
      // A gap's neighbours are edges, so both are single samples.
      if (!sample.step.gap) {
        sample.step.held = inputs.trace->meanBetween(before.middle, now.middle);
        if (now.last - now.first == 1)
          sample.step.slope = (series.current[first] - series.current[first - 1]) /
                              (series.time[first] - series.time[first - 1]);
      }
    } else {
      sample.step.held = now.current;
    }
    sample.voltage = now.voltage;
    // A masked sample is an edge on both sides, so it stands alone.
    const bool is_masked = !masked.empty() && masked[first];
    sample.count = is_masked ? 0.0 : static_cast<double>(now.last - now.first);
    inputs.samples.push_back(sample);
    before = now;
  }
  return inputs;
}

}  // namespace battery_sof
