#include <algorithm>
#include <cmath>
#include <numeric>

#include "check_parts.hpp"
#include "recording/channel_statistics.hpp"
#include "recording/moved_charge.hpp"
#include "util/constants.hpp"
#include "util/text.hpp"

/// Findings about when samples were taken, and which were not.
namespace battery_sof::check_parts {
namespace {

constexpr double kCrankDuration = 0.5;  // [s], of a typical engine start
constexpr double kFineInterval = 0.05;  // [s], ten samples in a crank
constexpr double kSlowInterval = 0.5;   // [s], one sample in a crank
constexpr double kUnevenSpread = 3.0;   // ratio of the 95th to the 5th percentile of the intervals
constexpr std::size_t kManyGaps = 20;   // so many alike are a slower rate, not losses
constexpr double kAlikeShare = 0.8;
constexpr double kLargeGapShare = 0.1;  // of the recording
// [s], a clock set back by less disturbs nothing slower than a crank
constexpr double kHarmlessStep = 1.0;

// Of a time column in another unit than seconds.
constexpr double kSlowestOfFine = 0.5;   // [s]; the milliseconds that loggers count would be 1 s
constexpr double kLargestBlock = 250.0;  // [Ah], of the largest 12 V blocks, those of heavy trucks
constexpr double kDailyOffset = 5.0;     // [Ah] a day, of a sensor whose zero is off by 0.2 A
constexpr double kSecondsPerDay = 86400.0;
constexpr double kSlowestOfRush = 2.0;     // [s]; a starter's rush is over before the next such row
constexpr std::size_t kFewestOfRush = 5;   // rows
constexpr double kLongestCranking = 30.0;  // [s], after which a starter motor has to cool down
constexpr double kRush =
    1.3;  // times the current that turns the engine, usually 1.7 (findCrankCurrent)
constexpr double kRushShare = 0.3;  // of a crank, in which the current is greatest
constexpr double kCrankDrop = 0.5;  // [V], of 150 A through 3.5 mOhm, those of a large block

/// Whether a discharge looks like an engine start of many rows: it begins with the greatest current,
/// that of a starter at standstill, which falls to well below it, and the voltage answers.
bool looksLikeCrank(const Series& series, IndexRange run, double crank_current) {
  const auto rows = static_cast<std::ptrdiff_t>(run.last - run.first);
  const auto size = static_cast<std::ptrdiff_t>(series.size());
  const auto first = static_cast<std::ptrdiff_t>(run.first), last = first + rows;
  const auto current = series.current.begin(), voltage = series.voltage.begin();
  const auto peak = std::min_element(current + first, current + last);
  const double typical = quantile({current + first, current + last}, 0.5);
  const double lowest = *std::min_element(voltage + first, voltage + last);
  const auto highestOf = [&](std::ptrdiff_t from, std::ptrdiff_t to) {
    return from < to ? *std::max_element(voltage + from, voltage + to) : lowest;
  };
  const double before = highestOf(std::max<std::ptrdiff_t>(first - rows, 0), first);
  const double after = highestOf(last, std::min(last + rows, size));
  return *peak <= crank_current && *peak <= kRush * typical &&
         kRushShare * static_cast<double>(rows) >= static_cast<double>(peak - current - first) &&
         std::min(before, after) - lowest >= kCrankDrop;
}

/// Discharges of a starter's size and course that last, as the time is read, longer than a starter
/// may turn, and in milliseconds would not.
std::vector<IndexRange> slowCranks(const Evidence& evidence) {
  std::vector<IndexRange> found;
  const Series& series = evidence.series;
  const EventLimits limits{evidence.crank_current};
  for (const IndexRange& stretch : evidence.stretches) {
    std::size_t first = stretch.first;
    while (first < stretch.last) {
      std::size_t last = first;
      while (last < stretch.last && series.current[last] <= limits.crankLevel()) ++last;
      const IndexRange run{first, last};
      first = last + 1;
      if (last - run.first < kFewestOfRush) continue;
      const double duration = durationOf(evidence, run);
      if (duration > kLongestCranking && 1e-3 * duration <= EventLimits::kCrankMaxDuration &&
          looksLikeCrank(series, run, limits.crank_current))
        found.push_back(run);
    }
  }
  return found;
}

struct Gaps {
  std::vector<double> from, length;
};

Gaps gapsOf(const Evidence& evidence) {
  Gaps gaps;
  for (std::size_t k = 1; k < evidence.stretches.size(); ++k) {
    const std::size_t next = evidence.stretches[k].first;
    gaps.from.push_back(evidence.series.time[next - 1]);
    gaps.length.push_back(evidence.series.time[next] - evidence.series.time[next - 1]);
  }
  return gaps;
}

/// Whether most gaps have one length: then nothing was lost, the logger was slower there.
bool areAlike(const std::vector<double>& lengths) {
  const double typical = quantile(lengths, 0.5);
  const auto alike = std::count_if(lengths.begin(), lengths.end(), [typical](double length) {
    return std::abs(length - typical) <= 0.1 * typical;
  });
  return lengths.size() >= kManyGaps && alike >= kAlikeShare * lengths.size();
}

std::string meaningOf(const Gaps& gaps) {
  if (!areAlike(gaps.length))
    return "models treat a gap as rest at 0 A and do not count the charge that flows in it";
  return "nearly all last " + number(quantile(gaps.length, 0.5)) +
         " s, which suggests a slower logging rate rather than lost samples; they still divide the "
         "recording, because fast changes inside them are not seen";
}

std::string describeClock(const RejectedCounts& rejected, double step) {
  std::string text;
  if (rejected.duplicate_stamp > 0) text = counted(rejected.duplicate_stamp, "repeated time stamp");
  if (rejected.clock_step_back == 0) return text;
  return text + (text.empty() ? "" : ", ") + counted(rejected.clock_step_back, "sample") +
         " after the clock was set back by up to " + number(step) + " s";
}

struct Losses {
  std::size_t samples = 0;
  std::vector<double> from;
};

/// Samples that a regular grid lacks between those there are; none where the intervals are of other
/// lengths than whole multiples, as those of a logger that writes on change are. Where many are
/// missing in a row, the logger was off or slow.
Losses lossesOf(const Evidence& evidence) {
  constexpr double kOnGrid = 0.1;     // of an interval
  constexpr double kRegular = 0.95;   // of the intervals; the others are of a clock that was set
  constexpr double kMaxInARow = 4.0;  // of one in ten lost at random, five in a row are one in 1e5
  constexpr double kUnbroken = 0.8;   // of the intervals; below, the rate is another
  Losses losses;
  std::size_t intervals = 0, single = 0, regular = 0;
  const std::vector<double>& time = evidence.series.time;
  for (const IndexRange& stretch : evidence.stretches) {
    for (std::size_t k = stretch.first + 1; k < stretch.last; ++k) {
      const double multiple = (time[k] - time[k - 1]) / evidence.interval;
      const double whole = std::round(multiple);
      ++intervals;
      if (whole < 1.0 || std::abs(multiple - whole) > kOnGrid) continue;
      ++regular;
      if (whole == 1.0) {
        ++single;
        continue;
      }
      if (whole - 1.0 > kMaxInARow) continue;
      losses.samples += static_cast<std::size_t>(whole) - 1;
      losses.from.push_back(time[k - 1]);
    }
  }
  const auto all = static_cast<double>(intervals);
  return regular >= kRegular * all && single >= kUnbroken * all ? losses : Losses{};
}

}  // namespace

namespace {

std::vector<Finding> findSlowCranks(const Evidence& evidence) {
  if (evidence.interval < kSlowestOfRush) return {};
  const std::vector<IndexRange> cranks = slowCranks(evidence);
  if (cranks.empty()) return {};
  const double longest = durationOf(
      evidence, *std::max_element(cranks.begin(), cranks.end(), [](IndexRange a, IndexRange b) {
        return a.last - a.first < b.last - b.first;
      }));
  return {Finding{"time_unit", Severity::kWarning,
                  counted(cranks.size(), "discharge") + " of " + number(-evidence.crank_current) +
                      " A or more with the course of an engine start, of up to " + number(longest) +
                      " s, where a starter turns for at most " + number(kLongestCranking) + " s",
                  "if these are engine starts, the time column counts milliseconds, not seconds: "
                  "read the file with --time-unit ms",
                  longest, "s", totalSamples(cranks), startsOf(evidence, cranks)}};
}

}  // namespace

std::vector<Finding> findTimeUnit(const Evidence& evidence) {
  const double swing = movedCharge(evidence.series, {0, evidence.series.size()}).span;
  const double days = durationOf(evidence, {0, evidence.series.size()}) / kSecondsPerDay;
  const double most = kLargestBlock + kDailyOffset * days;
  if (evidence.interval < kSlowestOfFine) return {};
  if (!(swing > most)) return findSlowCranks(evidence);
  return {Finding{"time_unit", Severity::kProblem,
                  number(swing) + " Ah flow in one direction within " + number(days) +
                      " days, more than the " + number(most) +
                      " Ah that a 12 V block and an offset of the sensor can account for",
                  "the time column probably counts milliseconds or microseconds, not seconds; read "
                  "the file with --time-unit ms or --time-unit us",
                  swing, "Ah", evidence.series.size()}};
}

std::vector<Finding> findSlowRate(const Evidence& evidence) {
  const double interval = evidence.interval;
  if (interval <= kFineInterval) return {};
  const bool is_slow = interval > kSlowInterval;
  return {Finding{"rate", is_slow ? Severity::kWarning : Severity::kNote,
                  interval > 2.0 ? "sampled every " + number(interval) + " s"
                                 : "sampled at " + number(1.0 / interval) + " Hz",
                  is_slow ? "a crank is seen in one sample at most, at an arbitrary instant, so "
                            "this recording shows slow behaviour but neither the lowest voltage of "
                            "a crank nor fast polarisation nor a shift between the channels"
                          : "a crank of " + number(kCrankDuration) + " s is seen in about " +
                                number(std::floor(kCrankDuration / interval)) +
                                " samples, so its lowest voltage is read too high",
                  interval, "s", evidence.series.size()}};
}

std::vector<Finding> findUnevenRate(const Evidence& evidence) {
  std::vector<double> intervals;
  const std::vector<double>& time = evidence.series.time;
  for (std::size_t k = 1; k < time.size(); ++k) intervals.push_back(time[k] - time[k - 1]);
  const double low = quantile(intervals, 0.05), high = quantile(intervals, 0.95);
  if (high < kUnevenSpread * low) return {};
  return {Finding{"rate", Severity::kNote,
                  "the sampling interval changes between " + number(low) + " s and " +
                      number(high) + " s (5th to 95th percentile)",
                  "the logger used several rates or wrote on change, so what happens in the long "
                  "intervals is not seen",
                  high / low, "", evidence.series.size()}};
}

std::vector<Finding> findHeldValues(const Evidence& evidence) {
  if (evidence.hold == 1) return {};
  const double held = static_cast<double>(evidence.hold) * evidence.interval;
  return {
      Finding{"rate", Severity::kWarning,
              "the current channel is updated only every " + counted(evidence.hold, "sample") +
                  " (" + number(held) + " s), the voltage channel at every sample",
              "between updates the current is out of date, so voltage edges without a current edge "
              "look like fast polarisation and bias the resistances; filter both channels below " +
                  number(0.25 / held) + " Hz before fitting",
              held, "s", evidence.series.size()}};
}

std::vector<Finding> findGaps(const Evidence& evidence) {
  const Gaps gaps = gapsOf(evidence);
  if (gaps.length.empty()) return {};
  const double total = std::accumulate(gaps.length.begin(), gaps.length.end(), 0.0);
  const double longest = *std::max_element(gaps.length.begin(), gaps.length.end());
  return {Finding{"gaps",
                  total > kLargeGapShare * durationOf(evidence, {0, evidence.series.size()}) &&
                          !areAlike(gaps.length)
                      ? Severity::kWarning
                      : Severity::kNote,
                  counted(gaps.length.size(), "gap") + " without samples, " + number(total) +
                      " s in all, the longest " + number(longest) + " s",
                  meaningOf(gaps), total, "s", gaps.length.size(), someTimes(gaps.from)}};
}

std::vector<Finding> findClock(const Evidence& evidence) {
  const RejectedCounts& rejected = evidence.recording->rejected;
  const std::size_t count = rejected.clock_step_back + rejected.duplicate_stamp;
  if (count == 0) return {};
  const double step = evidence.recording->largest_step_back;
  return {Finding{
      "clock",
      step > std::max(kHarmlessStep, evidence.interval) ? Severity::kWarning : Severity::kNote,
      describeClock(rejected, step),
      rejected.clock_step_back > 0
          ? "these samples were refused; durations across such a step are wrong by its size"
          : "only the first sample of each stamp was kept",
      step, "s", count}};
}

std::vector<Finding> findImpossibleTemperatures(const Evidence& evidence) {
  const std::size_t count = evidence.recording->rejected_temperatures;
  if (count == 0) return {};
  return {Finding{"temperature",
                  Severity::kWarning,
                  counted(count, "temperature") + " out of range",
                  "they are left out; -60 to 150 degC are expected",
                  {},
                  "",
                  count}};
}

std::vector<Finding> findRefused(const Evidence& evidence) {
  const RejectedCounts& rejected = evidence.recording->rejected;
  const std::size_t count = rejected.missing_value + rejected.not_finite + rejected.out_of_range,
                    offered = evidence.recording->offered;
  if (count == 0) return {};
  constexpr double kMostly = 50.0;  // [%]
  const double percent = 100.0 * static_cast<double>(count) / static_cast<double>(offered);
  if (percent > kMostly && rejected.out_of_range > count / 2)
    return {Finding{"missing", Severity::kProblem,
                    counted(rejected.out_of_range, "sample") + " of " + std::to_string(offered) +
                        " refused, because they are outside the range of any battery sensor",
                    "the remaining samples are no recording of a battery; currents are expected in "
                    "A and voltages in V, not in mA or mV",
                    percent, "%", count}};
  return {
      Finding{"missing", percent > 1.0 ? Severity::kWarning : Severity::kNote,
              counted(count, "sample") + " of " + std::to_string(offered) + " refused: " +
                  countsText({{rejected.missing_value, "without current or voltage"},
                              {rejected.not_finite, "infinite"},
                              {rejected.out_of_range, "outside the range of any battery sensor"}}),
              "they are left out and not replaced", percent, "%", count}};
}

std::vector<Finding> findLost(const Evidence& evidence) {
  // fewer are single events, reported as gaps if they are long
  constexpr std::size_t kFewestPlaces = 20;
  // a loss in every crank and a few seconds of each drive
  constexpr double kManyPercent = 0.5;
  const Losses losses = lossesOf(evidence);
  if (losses.from.size() < kFewestPlaces) return {};
  const auto lost = static_cast<double>(losses.samples);
  const double percent = 100.0 * lost / (lost + static_cast<double>(evidence.series.size()));
  return {Finding{"missing", percent >= kManyPercent ? Severity::kWarning : Severity::kNote,
                  counted(losses.samples, "sample") + " (" + twoDigits(percent) +
                      " %) lost from a regular grid of " + number(evidence.interval) + " s, in " +
                      counted(losses.from.size(), "place"),
                  "the logger or the bus drops messages; they are not replaced, and the peak of a "
                  "crank may be among them",
                  percent, "%", losses.samples, someTimes(losses.from)}};
}

}  // namespace battery_sof::check_parts
