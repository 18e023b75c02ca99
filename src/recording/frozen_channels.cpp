#include "recording/frozen_channels.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "recording/channel_statistics.hpp"
#include "util/constants.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kLookBack = 300.0;        // [s], a swing that takes longer is the battery's own
constexpr double kShortest = 5.0;          // [s], a crank may be cut off for as long as it lasts
constexpr std::size_t kFewest = 10;        // samples
constexpr std::size_t kTurns = 3;          // one dip and recovery can be the battery's own
constexpr std::size_t kRecent = 3000;      // samples, which noise and steps are taken from
constexpr double kNoiseSigmas = 9.0;       // 6.4 sigma of a difference
constexpr double kMostNoise = 0.1;         // of the largest current: nine sigmas of a poor sensor
constexpr double kMostVoltageNoise = 0.5;  // [V] of a block, likewise
constexpr double kMoveSteps = 2.5;        // quantisation alone moves by one step, with noise by two
constexpr double kLeastResistance = 0.1;  // [Ohm Ah], below that of any 12 V starter battery
constexpr double kLoadRate = 0.05;        // [1/h], the 20 h rate
constexpr double kSwing = 0.1;            // [V] of a block
// [V], of the coarsest battery sensor known, where the stream shows no step
constexpr double kCoarsestStep = 0.025;
constexpr double kLeastSlope = 0.8;  // [V] of a block for a unit of state of charge

/// [s], between the first and the last sample of a range that is not empty.
double durationOf(const Series& series, IndexRange range) {
  return series.time[range.last - 1] - series.time[range.first];
}

/// The samples up to the last one that read what it reads, without a gap among them.
template <typename Same>
IndexRange lastRun(const Series& series, double max_gap, double look_back, Same&& same) {
  IndexRange run{series.size() - 1, series.size()};
  while (run.first > 0 && same(run.first - 1) &&
         series.time[run.first] - series.time[run.first - 1] <= max_gap &&
         series.time[run.last - 1] - series.time[run.first] < look_back)
    --run.first;
  return run;
}

IndexRange lastRun(const Series& series, const std::vector<double>& values, double max_gap) {
  return lastRun(series, max_gap, kLookBack,
                 [&](std::size_t k) { return values[k] == values.back(); });
}

/// How often a channel turns round by at least an amplitude, however slowly.
std::size_t turnsOf(const std::vector<double>& values, IndexRange range, double amplitude) {
  std::size_t turns = 0;
  double low = values[range.first], high = low;
  int direction = 0;
  for (std::size_t k = range.first; k < range.last; ++k) {
    low = std::min(low, values[k]);
    high = std::max(high, values[k]);
    const bool rises = values[k] - low >= amplitude && direction <= 0;
    const bool falls = high - values[k] >= amplitude && direction >= 0;
    if (!rises && !falls) continue;
    if (direction != 0) ++turns;
    direction = rises ? 1 : -1;
    low = high = values[k];
  }
  return turns;
}

/// What a channel's values were like lately.
struct Recent {
  double step = 0.0;     // a usual small change; 0 where none changed
  double noise = 0.0;    // standard deviation, with what really changes from sample to sample
  double largest = 0.0;  // magnitude
};

Recent recentOf(const std::vector<double>& values, std::size_t last) {
  const auto end = values.begin() + static_cast<std::ptrdiff_t>(last);
  const std::vector<double> recent(end - static_cast<std::ptrdiff_t>(std::min(last, kRecent)), end);
  std::vector<double> changes;
  for (std::size_t k = 1; k < recent.size(); ++k)
    if (recent[k] != recent[k - 1]) changes.push_back(std::abs(recent[k] - recent[k - 1]));
  double largest = 0.0;
  for (const double value : recent) largest = std::max(largest, std::abs(value));
  return {quantile(std::move(changes), 0.25), noiseLevel(recent, std::nullopt), largest};
}

bool isLong(const Series& series, IndexRange run) {
  return run.size() >= kFewest && durationOf(series, run) >= kShortest;
}

std::optional<std::string> stuckVoltage(const Series& series, double capacity, double max_gap) {
  const IndexRange run = lastRun(series, series.voltage, max_gap);
  if (!isLong(series, run)) return std::nullopt;
  const Recent voltage = recentOf(series.voltage, run.first);
  const Recent current = recentOf(series.current, series.size());
  const double step = voltage.step > 0.0 ? voltage.step : kCoarsestStep;
  const double swing = std::max(
      {kMoveSteps * step * capacity / kLeastResistance,
       std::min(kNoiseSigmas * current.noise, kMostNoise * current.largest), kLoadRate * capacity});
  if (turnsOf(series.current, run, swing) < kTurns) return std::nullopt;
  return format(
      "the voltage is stuck: it has read one exact value for %.0f s while the current went "
      "up and down by more than %.0f A",
      durationOf(series, run), swing);
}

std::optional<std::string> stuckCurrent(const Series& series, double max_gap) {
  const IndexRange run = lastRun(series, series.current, max_gap);
  if (!isLong(series, run)) return std::nullopt;
  const Recent voltage = recentOf(series.voltage, series.size());
  const double swing = std::max({kSwing, std::min(kNoiseSigmas * voltage.noise, kMostVoltageNoise),
                                 kMoveSteps * voltage.step});
  if (turnsOf(series.voltage, run, swing) < kTurns) return std::nullopt;
  return format(
      "the current is stuck: it has read exactly %g A for %.0f s while the voltage of a "
      "block went up and down by more than %.2f V",
      series.current.back(), durationOf(series, run), swing);
}

/// How both channels stood still under load before.
struct StoodStill {
  double longest = 0.0;  // [s]
  double loaded = 0.0;   // [s], under load
};

StoodStill stoodStillBefore(const Series& series, std::size_t last, double load, double max_gap) {
  StoodStill before;
  double run = 0.0;
  for (std::size_t k = 1; k < last; ++k) {
    const double interval = series.time[k] - series.time[k - 1];
    const bool is_loaded = interval <= max_gap && std::abs(series.current[k]) >= load;
    if (is_loaded) before.loaded += interval;
    const bool repeats = is_loaded && series.current[k] == series.current[k - 1] &&
                         series.voltage[k] == series.voltage[k - 1];
    run = repeats ? run + interval : 0.0;
    before.longest = std::max(before.longest, run);
  }
  return before;
}

std::optional<std::string> stuckBoth(const Series& series, double capacity, double max_gap) {
  constexpr double kLeast = 60.0;           // [s]
  constexpr double kFarLonger = 10.0;       // times
  constexpr double kEnoughShown = 600.0;    // [s]
  constexpr double kMovesForCertain = 2.0;  // steps' times
  const double load = kLoadRate * capacity, current = std::abs(series.current.back());
  if (current < load) return std::nullopt;
  const IndexRange run =
      lastRun(series, max_gap, series.time.back() - series.time.front() + 1.0, [&](std::size_t k) {
        return series.current[k] == series.current.back() &&
               series.voltage[k] == series.voltage.back();
      });
  const double duration = durationOf(series, run);
  if (run.size() < kFewest || duration < kLeast) return std::nullopt;
  const StoodStill before = stoodStillBefore(series, run.first, load, max_gap);
  double limit = std::max(kLeast, kFarLonger * before.longest);
  if (before.loaded < kEnoughShown) {
    const double step = recentOf(series.voltage, run.first).step;
    limit = kMovesForCertain * kSecondsPerHour * (step > 0.0 ? step : kCoarsestStep) * capacity /
            (kLeastSlope * current);
  }
  if (duration < limit) return std::nullopt;
  return format(
      "both channels are stuck: the current has read exactly %g A and the voltage one "
      "exact value for %.0f s; under load both never stood still for longer than %.0f s "
      "before",
      series.current.back(), duration, before.longest);
}

}  // namespace

std::optional<std::string> frozenChannels(const Series& series, double capacity, double max_gap) {
  if (series.size() < kFewest) return std::nullopt;
  auto found = stuckVoltage(series, capacity, max_gap);
  if (!found) found = stuckCurrent(series, max_gap);
  return found ? found : stuckBoth(series, capacity, max_gap);
}

RepeatingChannels repeatingChannels(const Series& series, double capacity, double max_gap) {
  if (series.empty()) return {};
  const double load = kLoadRate * capacity;
  const auto jumps = [&](const std::vector<double>& of, const std::vector<double>& other,
                         double least, bool needs_load) {
    const IndexRange run = lastRun(series, of, max_gap);
    if (!isLong(series, run)) return false;
    bool moved = false, loaded = !needs_load;
    for (std::size_t k = run.first + 1; k < run.last; ++k) {
      moved = moved || std::abs(other[k] - other[k - 1]) >= least;
      loaded = loaded || std::abs(series.current[k]) >= load;
    }
    return moved && loaded;
  };
  return {jumps(series.current, series.voltage, kSwing, false),
          jumps(series.voltage, series.current, load, true)};
}

}  // namespace battery_sof
