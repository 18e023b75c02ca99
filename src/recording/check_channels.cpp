#include <algorithm>
#include <cmath>

#include "battery_sof/recording/channel_statistics.hpp"
#include "check_parts.hpp"

/// Findings about one channel's values, judged by what the other channel does meanwhile.
namespace battery_sof::check_parts {
namespace {

constexpr double kCoarseVoltage = 0.005;     // [V], a crank's drop of 2 V in 400 steps
constexpr double kVeryCoarseVoltage = 0.05;  // [V]
constexpr double kCoarseCurrent =
    0.05;  // [A], the least current offset worth finding (PHYSICS 1.3, I1)
constexpr double kVeryCoarseCurrent = 1.0;  // [A]
constexpr double kNoiseSigmas = 9.0;  // 6.4 sigma of a difference: no move by chance in 1e9 samples
constexpr double kMoveSteps = 2.5;    // quantisation alone moves by one step, with noise by two
constexpr double kMoveShare = 0.05;   // of what the largest current does to the other channel
constexpr double kMoveDuration = 0.05;   // [s], over which a move is taken; shorter than a crank
constexpr std::size_t kFlatSamples = 3;  // PHYSICS 1.3, I7
constexpr double kFlatDuration = 5.0;    // [s], a crank lasts no longer
constexpr std::size_t kStuckSamples = 10;
constexpr std::size_t kStuckReversals =
    3;  // one dip and recovery can be the battery's own; three cannot
constexpr std::size_t kPileUpSamples = 5;
constexpr double kPileUpInterval = 0.2;  // [s], slower sampling shows cranks as single samples
constexpr double kVoltageSpread = 0.1;   // of the drop at the extreme current

struct Move {
  std::size_t stride;
  double threshold;
};

/// Least move of the channel that neither noise nor quantisation of either channel explains.
Move realMove(const Evidence& evidence, const Channel& channel) {
  const bool is_voltage = &channel == &evidence.voltage;
  const double resistance = evidence.edges ? std::abs(evidence.edges->resistance) : 0.0;
  const double scale =
      is_voltage ? resistance * evidence.largest_current : evidence.largest_current;
  double threshold = std::max(
      {kNoiseSigmas * channel.noise, kMoveSteps * channel.step.value_or(0.0), kMoveShare * scale});
  if (!is_voltage && resistance > 0.0) {
    threshold = std::max(threshold, kMoveSteps * evidence.voltage.step.value_or(0.0) / resistance);
  }
  const double stride = evidence.interval > 0.0 ? kMoveDuration / evidence.interval : 1.0;
  return {static_cast<std::size_t>(std::max(1L, std::lround(stride))), threshold};
}

const Channel& otherThan(const Evidence& evidence, const Channel& channel) {
  return &channel == &evidence.current ? evidence.voltage : evidence.current;
}

/// The run without the samples at its ends in which a shift between the channels shows the
/// neighbours' edges.
IndexRange withoutSkew(const Evidence& evidence, IndexRange run) {
  if (!evidence.edges || evidence.interval <= 0.0) return run;
  const auto lag =
      static_cast<std::size_t>(std::ceil(std::abs(evidence.edges->lag) / evidence.interval));
  if (run.size() <= 2 * lag) return {run.first, run.first};
  return {run.first + lag, run.last - lag};
}

std::size_t reversalsDuring(const Evidence& evidence, const Channel& other, IndexRange run) {
  const Move move = realMove(evidence, other);
  return countReversals(other.values, withoutSkew(evidence, run), move.stride, move.threshold);
}

std::vector<IndexRange> runsOf(const Evidence& evidence, const Channel& channel,
                               std::size_t min_samples) {
  std::vector<IndexRange> runs;
  for (const IndexRange& stretch : evidence.stretches) {
    const auto found = constantRuns(channel.values, stretch, min_samples);
    runs.insert(runs.end(), found.begin(), found.end());
  }
  return runs;
}

double durationOf(const Evidence& evidence, IndexRange run) {
  return evidence.series.time[run.last - 1] - evidence.series.time[run.first];
}

std::size_t totalSamples(const std::vector<IndexRange>& runs) {
  std::size_t samples = 0;
  for (const IndexRange& run : runs) samples += run.size();
  return samples;
}

std::vector<double> startsOf(const Evidence& evidence, const std::vector<IndexRange>& runs) {
  std::vector<double> starts;
  for (const IndexRange& run : runs) starts.push_back(evidence.series.time[run.first]);
  return someTimes(starts);
}

// ---------------------------------------------------------------------------------------------
// quantisation

std::vector<Finding> findCoarseStep(const Channel& channel, double coarse, double very_coarse,
                                    const std::string& meaning) {
  const double step = channel.step.value_or(0.0);
  if (step < coarse * (1.0 - 1e-3)) return {};
  Finding finding;
  finding.id = "quantisation";
  finding.severity = step < very_coarse * (1.0 - 1e-3) ? Severity::kNote : Severity::kWarning;
  finding.what =
      std::string(channel.name) + " comes in steps of " + number(step) + " " + channel.unit;
  finding.meaning =
      "each value is known to +-" + number(0.5 * step) + " " + channel.unit + "; " + meaning;
  finding.value = step;
  finding.unit = channel.unit;
  finding.samples = channel.values.size();
  return {finding};
}

// ---------------------------------------------------------------------------------------------
// clipping

bool isAtExtreme(const Channel& channel, IndexRange run, double extreme) {
  return channel.values[run.first] == extreme;
}

/// Flat tops during which the other channel turns round: the true peak lies beyond the limit.
std::vector<IndexRange> flatTops(const Evidence& evidence, const Channel& channel, double extreme) {
  const Channel& other = otherThan(evidence, channel);
  std::vector<IndexRange> tops;
  for (const IndexRange& run :
       runsOf(evidence, channel, std::max(kFlatSamples, 2 * evidence.hold))) {
    if (!isAtExtreme(channel, run, extreme)) continue;
    const bool is_brief = durationOf(evidence, run) <= kFlatDuration;
    const std::size_t needed = is_brief ? 1 : kStuckReversals;
    if (reversalsDuring(evidence, other, run) >= needed) tops.push_back(run);
  }
  return tops;
}

/// Samples of the current between half the extreme and 2 % short of it, and how many different
/// values they have.
struct Crowd {
  std::size_t samples = 0, values = 0, near = 0;
};

Crowd crowdBelow(const Channel& channel, double extreme) {
  std::vector<double> crowd;
  for (const double value : channel.values) {
    if (value != extreme && value / extreme > 0.5) crowd.push_back(value);
  }
  std::sort(crowd.begin(), crowd.end());
  Crowd result;
  result.samples = crowd.size();
  result.near = std::count_if(crowd.begin(), crowd.end(),
                              [extreme](double value) { return value / extreme > 0.98; });
  crowd.erase(std::unique(crowd.begin(), crowd.end()), crowd.end());
  result.values = crowd.size();
  return result;
}

double voltageSpread(const Evidence& evidence, const std::vector<IndexRange>& runs) {
  std::vector<double> voltages;
  for (const IndexRange& run : runs) voltages.push_back(evidence.series.voltage[run.first]);
  return quantile(voltages, 0.9) - quantile(voltages, 0.1);
}

/// Separate samples that share one extreme current, though the currents below it are scattered and
/// the voltages differ.
std::vector<IndexRange> pileUp(const Evidence& evidence, double extreme) {
  if (evidence.interval < kPileUpInterval || !evidence.edges) return {};
  std::vector<IndexRange> runs = runsOf(evidence, evidence.current, 1);
  runs.erase(std::remove_if(runs.begin(), runs.end(),
                            [&](const IndexRange& run) {
                              return !isAtExtreme(evidence.current, run, extreme);
                            }),
             runs.end());
  const std::size_t samples = totalSamples(runs);
  const Crowd crowd = crowdBelow(evidence.current, extreme);
  const bool stands_out =
      runs.size() >= kPileUpSamples && samples <= 2 * runs.size() && 3 * crowd.near <= samples;
  const bool is_scattered = 4 * crowd.samples >= samples && 2 * crowd.values >= crowd.samples;
  const double drop = evidence.edges->resistance * std::abs(extreme);
  const bool voltages_differ = voltageSpread(evidence, runs) >= kVoltageSpread * std::abs(drop);
  return stands_out && is_scattered && voltages_differ ? runs : std::vector<IndexRange>{};
}

Finding clippingAt(const Evidence& evidence, const Channel& channel, double extreme,
                   const std::vector<IndexRange>& runs) {
  Finding finding;
  finding.id = "clipping";
  finding.severity = Severity::kWarning;
  finding.what = std::string(channel.name) + " is cut off at " + number(extreme) + " " +
                 channel.unit + ": " + counted(totalSamples(runs), "sample") + " in " +
                 counted(runs.size(), "place") + " read exactly that";
  finding.meaning =
      &channel == &evidence.current
          ? "the true current lay beyond: resistances fitted through these samples come out too "
            "large, "
            "and charge is missing; leave them out of fits"
          : "the true voltage lay beyond: leave these samples out of fits and of scores";
  finding.value = extreme;
  finding.unit = channel.unit;
  finding.samples = totalSamples(runs);
  finding.at = startsOf(evidence, runs);
  return finding;
}

// ---------------------------------------------------------------------------------------------
// stuck values

std::vector<Finding> findFrozen(const Evidence& evidence, const Channel& channel) {
  const Channel& other = otherThan(evidence, channel);
  std::vector<IndexRange> frozen;
  double longest = 0.0;
  for (const IndexRange& run :
       runsOf(evidence, channel, std::max(kStuckSamples, 4 * evidence.hold))) {
    if (reversalsDuring(evidence, other, run) < kStuckReversals) continue;
    frozen.push_back(run);
    longest = std::max(longest, durationOf(evidence, run));
  }
  if (frozen.empty()) return {};
  Finding finding;
  finding.id = "stuck";
  finding.severity = Severity::kWarning;
  finding.what = std::string(channel.name) + " repeats one value while " + other.name +
                 " moves up and down: " + counted(frozen.size(), "time") + ", " +
                 counted(totalSamples(frozen), "sample") + ", the longest " + number(longest) +
                 " s";
  finding.meaning = std::string("the ") + channel.name +
                    " is not measured there (sensor asleep, or its last message repeated); leave "
                    "these stretches out";
  finding.value = longest;
  finding.unit = "s";
  finding.samples = totalSamples(frozen);
  finding.at = startsOf(evidence, frozen);
  return {finding};
}

/// Samples outside the runs, and the share of them at which the channel turns round: 2/3 for white
/// noise, little for curves.
struct Flicker {
  std::size_t samples = 0;
  double turning = 0.0;
  double size = 0.0;  ///< median change
};

Flicker flickerOutside(const Channel& channel, const std::vector<IndexRange>& runs) {
  std::vector<double> changes;
  std::size_t turns = 0, next = 0;
  for (std::size_t k = 1; k + 1 < channel.values.size(); ++k) {
    while (next < runs.size() && runs[next].last <= k) ++next;
    if (next < runs.size() && k >= runs[next].first) continue;
    const double before = channel.values[k] - channel.values[k - 1];
    if (before * (channel.values[k + 1] - channel.values[k]) < 0.0) ++turns;
    changes.push_back(std::abs(before));
  }
  if (changes.empty()) return {};
  const double turning = static_cast<double>(turns) / static_cast<double>(changes.size());
  return {changes.size(), turning, quantile(changes, 0.5)};
}

/// Whether the channel turns round at most samples outside the runs, by more than quantisation and
/// rounding do.
bool isNoisyOutside(const Channel& channel, const Flicker& flicker) {
  constexpr double kFlickerShare = 0.1;   // of the recording
  constexpr double kTurning = 0.4;        // white noise turns at 2/3 of its samples
  constexpr double kLeastFlicker = 1e-5;  // of the largest value; less is rounding of computed data
  const double largest = std::max(std::abs(channel.lowest), std::abs(channel.highest));
  return flicker.samples > kFlickerShare * channel.values.size() && flicker.turning > kTurning &&
         flicker.size >= kLeastFlicker * largest &&
         flicker.size >= kMoveSteps * channel.step.value_or(0.0);
}

Finding enteredAt(const Evidence& evidence, const Channel& channel, const Flicker& flicker,
                  const std::vector<IndexRange>& runs) {
  const IndexRange longest = *std::max_element(
      runs.begin(), runs.end(), [](IndexRange a, IndexRange b) { return a.size() < b.size(); });
  const double duration = durationOf(evidence, longest);
  Finding finding;
  finding.id = "stuck";
  finding.what =
      std::string(channel.name) + " reads exactly " + number(channel.values[longest.first]) + " " +
      channel.unit + " for " + counted(longest.size(), "sample") + " (" + number(duration) +
      " s), though it flickers by " + number(flicker.size) + " " + channel.unit + " elsewhere; " +
      counted(totalSamples(runs), "sample") + " in " + counted(runs.size(), "such place");
  finding.meaning =
      "set or entered there rather than measured; fits and counted charge take it as exact";
  finding.value = duration;
  finding.unit = "s";
  finding.samples = totalSamples(runs);
  finding.at = startsOf(evidence, runs);
  return finding;
}

/// Values that stand still for a minute and more although the channel flickers at nearly every
/// sample elsewhere.
std::vector<Finding> findEntered(const Evidence& evidence, const Channel& channel) {
  constexpr double kShortest = 60.0;   // [s]
  constexpr std::size_t kFewest = 20;  // samples
  std::vector<IndexRange> runs = runsOf(evidence, channel, kFewest);
  const Flicker flicker = flickerOutside(channel, runs);
  runs.erase(
      std::remove_if(runs.begin(), runs.end(),
                     [&](const IndexRange& run) { return durationOf(evidence, run) < kShortest; }),
      runs.end());
  if (runs.empty() || !isNoisyOutside(channel, flicker)) return {};
  return {enteredAt(evidence, channel, flicker, runs)};
}

// ---------------------------------------------------------------------------------------------
// held values

/// Median length of the runs of one value under load, when most runs have it; 1 otherwise.
std::size_t regularHold(const Evidence& evidence) {
  constexpr std::size_t kFewestRuns = 50;
  constexpr double kLongest = 50.0;
  constexpr double kRegularShare = 0.8;
  constexpr double kLoad = 0.05;  // of the largest current
  std::vector<double> lengths;
  for (const IndexRange& run : runsOf(evidence, evidence.current, 1)) {
    const double current = evidence.current.values[run.first];
    if (std::abs(current) <= kLoad * evidence.largest_current) continue;
    lengths.push_back(static_cast<double>(run.size()));
  }
  const double typical = quantile(lengths, 0.5);
  const auto regular = std::count_if(lengths.begin(), lengths.end(), [typical](double length) {
    return std::abs(length - typical) <= 1.0;
  });
  const bool is_regular = lengths.size() >= kFewestRuns && typical <= kLongest &&
                          regular >= kRegularShare * lengths.size();
  return is_regular ? static_cast<std::size_t>(typical) : 1;
}

/// Whether the voltage often moves between two samples at which the current reads the same.
bool movesWithoutCurrent(const Evidence& evidence) {
  constexpr std::size_t kFewestMoves = 50;
  constexpr double kUnexplainedShare = 0.4;
  const auto &current = evidence.series.current, &voltage = evidence.series.voltage;
  const double threshold = realMove(evidence, evidence.voltage).threshold;
  std::size_t moves = 0, unexplained = 0;
  for (std::size_t k = 1; k < current.size(); ++k) {
    if (std::abs(voltage[k] - voltage[k - 1]) < threshold) continue;
    ++moves;
    if (current[k] == current[k - 1]) ++unexplained;
  }
  return moves >= kFewestMoves && unexplained > kUnexplainedShare * moves;
}

}  // namespace

std::vector<Finding> findQuantisation(const Evidence& evidence) {
  std::vector<Finding> findings = findCoarseStep(
      evidence.voltage, kCoarseVoltage, kVeryCoarseVoltage,
      "differences between model and measurement below that say nothing sample by sample, "
      "and slow effects of a few mV show only in averages");
  const auto current = findCoarseStep(evidence.current, kCoarseCurrent, kVeryCoarseCurrent,
                                      "small rest and float currents are known no better");
  findings.insert(findings.end(), current.begin(), current.end());
  return findings;
}

std::vector<Finding> findClipping(const Evidence& evidence) {
  std::vector<Finding> findings;
  for (const Channel* channel : {&evidence.current, &evidence.voltage}) {
    for (const double extreme : {channel->lowest, channel->highest}) {
      std::vector<IndexRange> runs = flatTops(evidence, *channel, extreme);
      if (channel == &evidence.current) {
        const std::vector<IndexRange> piled = pileUp(evidence, extreme);
        if (piled.size() > runs.size()) runs = piled;
      }
      if (!runs.empty()) findings.push_back(clippingAt(evidence, *channel, extreme, runs));
    }
  }
  return findings;
}

std::vector<Finding> findStuck(const Evidence& evidence) {
  std::vector<Finding> findings;
  for (const Channel* channel : {&evidence.current, &evidence.voltage}) {
    std::vector<Finding> found = findFrozen(evidence, *channel);
    if (found.empty()) found = findEntered(evidence, *channel);
    findings.insert(findings.end(), found.begin(), found.end());
  }
  return findings;
}

std::size_t updateInterval(const Evidence& evidence) {
  if (!evidence.fast || !evidence.edges) return 1;
  const std::size_t hold = regularHold(evidence);
  return hold > 1 && movesWithoutCurrent(evidence) ? hold : 1;
}

}  // namespace battery_sof::check_parts
