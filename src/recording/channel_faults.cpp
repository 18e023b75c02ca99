#include <algorithm>
#include <cmath>

#include "check_parts.hpp"
#include "recording/channel_statistics.hpp"
#include "util/text.hpp"

/// Where a channel's values are proven wrong, judged by what the other channel does meanwhile, and
/// the findings that report it.
namespace battery_sof::check_parts {
namespace {

constexpr double kNoiseSigmas = 9.0;  // 6.4 sigma of a difference: no move by chance in 1e9 samples
constexpr double kMoveSteps = 2.5;    // quantisation alone moves by one step, with noise by two
// of what the largest current does to the other channel: a current sensor's error
constexpr double kMoveShare = 0.02;
constexpr double kMoveDuration = 0.05;   // [s], over which a move is taken; shorter than a crank
constexpr std::size_t kFlatSamples = 3;  // docs/physics.md#clipping
constexpr double kFlatDuration = 5.0;    // [s], a crank lasts no longer
// [V], by which a voltage flickers under a current that a bench holds for longer than that
constexpr double kHeldFlicker = 0.02;
constexpr std::size_t kStuckSamples = 10;
// one dip and recovery can be the battery's own; three cannot
constexpr std::size_t kStuckReversals = 3;
constexpr std::size_t kPileUpSamples = 5;
constexpr double kPileUpInterval = 0.2;  // [s], slower sampling shows cranks as single samples
constexpr double kTurning = 0.4;        // white noise turns at 2/3 of its moves, curves hardly ever
constexpr double kVoltageSpread = 0.1;  // of the drop at the extreme current
constexpr double kLoad = 0.05;          // of the largest current
// channels that mostly stand still do so together when the battery does
constexpr double kMostlyStill = 0.8;
constexpr double kFlickerShare = 0.1;        // of the recording
constexpr double kChance = 1e-3;             // of one false claim in the whole recording
constexpr double kCoarseVoltage = 0.005;     // [V], a crank's drop of 2 V in 400 steps
constexpr double kVeryCoarseVoltage = 0.05;  // [V]
// [A], the least current offset worth finding (docs/physics.md#current_offset)
constexpr double kCoarseCurrent = 0.05;
constexpr double kVeryCoarseCurrent = 1.0;  // [A]
constexpr double kAlmost = 1.0 - 1e-3;      // of a limit: printed steps are rounded

/// A change of a channel over stride samples, in the channel's unit.
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
  if (!is_voltage && resistance > 0.0)
    threshold = std::max(threshold, kMoveSteps * evidence.voltage.step.value_or(0.0) / resistance);
  const double stride = evidence.interval > 0.0 ? kMoveDuration / evidence.interval : 1.0;
  return {static_cast<std::size_t>(std::max(1L, std::lround(stride))), threshold};
}

const Channel& otherThan(const Evidence& evidence, const Channel& channel) {
  return &channel == &evidence.current ? evidence.voltage : evidence.current;
}

/// @return ranges between gaps in which one exact value repeats at least min_samples times.
std::vector<IndexRange> runsOf(const Evidence& evidence, const Channel& channel,
                               std::size_t min_samples) {
  return constantRuns(channel.values, evidence.stretches, min_samples);
}

/// How often another channel turns round during a run, but for the samples at its ends in which a
/// shift between the channels shows the neighbours' edges.
std::size_t reversalsDuring(const Evidence& evidence, const Channel& other, IndexRange run) {
  if (evidence.edges && evidence.interval > 0.0) {
    const auto lag =
        static_cast<std::size_t>(std::ceil(std::abs(evidence.edges->lag) / evidence.interval));
    run = run.size() <= 2 * lag ? IndexRange{run.first, run.first}
                                : IndexRange{run.first + lag, run.last - lag};
  }
  Move move = realMove(evidence, other);
  if (&other == &evidence.voltage && durationOf(evidence, run) > kFlatDuration)
    move.threshold = std::max(move.threshold, kHeldFlicker);
  return countReversals(other.values, run, move.stride, move.threshold);
}

bool isUnderLoad(const Evidence& evidence, std::size_t k) {
  return std::abs(evidence.current.values[k]) > kLoad * evidence.largest_current;
}

bool isAtExtreme(const Channel& channel, IndexRange run, double extreme) {
  return channel.values[run.first] == extreme;
}

/// Flat tops during which the other channel turns round: the true peak lies beyond the limit.
std::vector<IndexRange> flatTops(const Evidence& evidence, const Channel& channel, double extreme) {
  const Channel& other = otherThan(evidence, channel);
  return thoseWhere(
      runsOf(evidence, channel, std::max(kFlatSamples, 2 * evidence.hold)), [&](IndexRange run) {
        const bool is_brief = durationOf(evidence, run) <= kFlatDuration;
        return isAtExtreme(channel, run, extreme) &&
               reversalsDuring(evidence, other, run) >= (is_brief ? 1 : kStuckReversals);
      });
}

/// Whether two samples are of one reading, as far as the values tell.
bool repeats(const Channel& channel, std::size_t k) {
  return channel.values[k] == channel.values[k - 1];
}

/// Share of tries that succeed, by Laplace's rule of succession.
double laplaceShare(std::size_t successes, std::size_t tries) {
  return static_cast<double>(successes + 1) / static_cast<double>(tries + 2);
}

/// Samples that repeat the one before, and those after which another one does.
struct Repetitions {
  std::size_t samples = 0, repeated = 0, begun = 0, gone_on = 0;
};

/// @param counts bool(k), of a sample and the one before it.
template <typename Counts>
Repetitions repetitionsUnderLoad(const Evidence& evidence, const Channel& channel,
                                 Counts&& counts) {
  Repetitions found;
  for (std::size_t k = 2; k < channel.values.size(); ++k) {
    if (!isUnderLoad(evidence, k) || !counts(k)) continue;
    ++found.samples;
    found.repeated += repeats(channel, k);
    if (!repeats(channel, k - 1) || !counts(k - 1)) continue;
    ++found.begun;
    found.gone_on += repeats(channel, k);
  }
  return found;
}

/// Share of a channel's repetitions under load, away from its limits, that another one follows. Of
/// white noise it is the chance of a repetition, of values that somebody holds it is nearly 1.
double shareThatGoesOn(const Evidence& evidence, const Channel& channel) {
  const Repetitions found = repetitionsUnderLoad(evidence, channel, [&](std::size_t k) {
    return channel.values[k - 1] != channel.lowest && channel.values[k - 1] != channel.highest;
  });
  return laplaceShare(found.gone_on, found.begun);
}

/// Whether the channel turns round at most of its moves under load, as noise does, be it of less
/// than a step.
bool flickersUnderLoad(const Evidence& evidence, const Channel& channel) {
  std::size_t moves = 0, turns = 0;
  double before = 0.0;
  for (std::size_t k = 1; k < channel.values.size(); ++k) {
    const double move = channel.values[k] - channel.values[k - 1];
    if (move == 0.0 || !isUnderLoad(evidence, k)) continue;
    ++moves;
    if (move * before < 0.0) ++turns;
    before = move;
  }
  return moves > kFlickerShare * static_cast<double>(channel.values.size()) &&
         turns > kTurning * static_cast<double>(moves);
}

bool isApproachedSteeply(const Evidence& evidence, const Channel& channel, IndexRange run) {
  const Move move = realMove(evidence, channel);
  if (run.first < move.stride || run.last + move.stride > channel.values.size()) return false;
  const double extreme = channel.values[run.first];
  return std::abs(channel.values[run.first - move.stride] - extreme) >= move.threshold &&
         std::abs(channel.values[run.last + move.stride - 1] - extreme) >= move.threshold;
}

/// Flat tops of a channel that flickers elsewhere, too long for its own noise to leave them out: in
/// several places, or in one that lies between two steep flanks. They need nothing of the other
/// channel, which may be cut off too.
std::vector<IndexRange> silentTops(const Evidence& evidence, const Channel& channel,
                                   double extreme) {
  if (evidence.interval >= kPileUpInterval || !flickersUnderLoad(evidence, channel)) return {};
  const double share = shareThatGoesOn(evidence, channel);
  std::vector<IndexRange> tops =
      thoseWhere(runsOf(evidence, channel, kFlatSamples), [&](IndexRange run) {
        const double chance = std::pow(share, static_cast<double>(run.size() - 2));
        return isAtExtreme(channel, run, extreme) && durationOf(evidence, run) <= kFlatDuration &&
               static_cast<double>(channel.values.size()) * chance < kChance;
      });
  if (tops.size() == 1 && !isApproachedSteeply(evidence, channel, tops.front())) tops.clear();
  return tops;
}

/// Separate samples that share one extreme current, though the currents below it, from half of it
/// on, are scattered and the voltages differ.
std::vector<IndexRange> pileUp(const Evidence& evidence, double extreme) {
  if (evidence.interval < kPileUpInterval || !evidence.edges) return {};
  const std::vector<IndexRange> runs =
      thoseWhere(runsOf(evidence, evidence.current, 1),
                 [&](IndexRange run) { return isAtExtreme(evidence.current, run, extreme); });
  std::vector<double> voltages, crowd;
  for (const IndexRange& run : runs) voltages.push_back(evidence.series.voltage[run.first]);
  for (const double value : evidence.current.values)
    if (value != extreme && value / extreme > 0.5) crowd.push_back(value);
  const std::size_t samples = totalSamples(runs), below = crowd.size();
  const auto near = static_cast<std::size_t>(std::count_if(
      crowd.begin(), crowd.end(), [extreme](double value) { return value / extreme > 0.98; }));
  std::sort(crowd.begin(), crowd.end());
  const auto values =
      static_cast<std::size_t>(std::unique(crowd.begin(), crowd.end()) - crowd.begin());
  const bool stands_out =
      runs.size() >= kPileUpSamples && samples <= 2 * runs.size() && 3 * near <= samples;
  const bool is_scattered = 4 * below >= samples && 2 * values >= below;
  const double drop = evidence.edges->resistance * std::abs(extreme);
  const bool voltages_differ =
      quantile(voltages, 0.9) - quantile(voltages, 0.1) >= kVoltageSpread * std::abs(drop);
  return stands_out && is_scattered && voltages_differ ? runs : std::vector<IndexRange>{};
}

/// Ranges of one value pair under load, of two samples or more.
std::vector<IndexRange> pairRuns(const Evidence& evidence) {
  const auto loaded = thoseWhere(runsOf(evidence, evidence.current, 2),
                                 [&](IndexRange run) { return isUnderLoad(evidence, run.first); });
  return constantRuns(evidence.voltage.values, loaded, 2);
}

/// Share of a channel's repetitions under load that another one follows while the other channel
/// moves: what a repeated message is, is not counted.
double shareThatGoesOnAlone(const Evidence& evidence, const Channel& channel) {
  const Channel& other = otherThan(evidence, channel);
  const Repetitions found =
      repetitionsUnderLoad(evidence, channel, [&](std::size_t k) { return !repeats(other, k); });
  // Of rare repetitions too few begin to tell how they go on.
  constexpr std::size_t kEnough = 30;
  return found.begun >= kEnough ? laplaceShare(found.gone_on, found.begun)
                                : laplaceShare(found.repeated, found.samples);
}

/// Where the channel is cut off at an extreme, its lowest or highest value, by the one of three
/// kinds of evidence that sees it most often. What a source or a regulator holds is not found.
std::vector<IndexRange> clippedRuns(const Evidence& evidence, const Channel& channel,
                                    double extreme) {
  std::vector<IndexRange> runs = flatTops(evidence, channel, extreme);
  std::vector<IndexRange> silent = silentTops(evidence, channel, extreme);
  if (silent.size() > runs.size()) runs = std::move(silent);
  if (&channel != &evidence.current) return runs;
  std::vector<IndexRange> piled = pileUp(evidence, extreme);
  return piled.size() > runs.size() ? piled : runs;
}

/// Samples outside given ranges, and the share of them at which the channel turns round: 2/3 for
/// white noise, little for curves.
struct Flicker {
  std::size_t samples = 0;
  double turning = 0.0;
  double size = 0.0;  ///< median change
};

/// @param runs in order.
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
  constexpr double kMinFlicker = 1e-5;  // of the largest value; less is rounding of computed data
  const double largest = std::max(std::abs(channel.lowest), std::abs(channel.highest));
  return flicker.samples > kFlickerShare * channel.values.size() && flicker.turning > kTurning &&
         flicker.size >= kMinFlicker * largest &&
         flicker.size >= kMoveSteps * channel.step.value_or(0.0);
}

Finding coarseStep(const Channel& channel, double very_coarse, const std::string& meaning) {
  const double step = *channel.step;
  return Finding{
      "quantisation",
      step < very_coarse * kAlmost ? Severity::kNote : Severity::kWarning,
      std::string(channel.name) + " has steps of " + number(step) + " " + channel.unit,
      "each value is known to +-" + number(0.5 * step) + " " + channel.unit + "; " + meaning,
      step,
      channel.unit,
      channel.values.size()};
}

std::vector<Finding> findFrozen(const Evidence& evidence, const Channel& channel) {
  const Channel& other = otherThan(evidence, channel);
  const std::vector<IndexRange> frozen = frozenRuns(evidence, channel);
  if (frozen.empty()) return {};
  double longest = 0.0;
  for (const IndexRange& run : frozen) longest = std::max(longest, durationOf(evidence, run));
  return {Finding{"stuck", Severity::kWarning,
                  std::string(channel.name) + " repeats one value while " + other.name +
                      " moves up and down: " + counted(frozen.size(), "time") + ", " +
                      counted(totalSamples(frozen), "sample") + ", the longest " + number(longest) +
                      " s",
                  std::string("the ") + channel.name +
                      " was not measured there (the sensor was asleep, or its last message was "
                      "repeated); leave these stretches out",
                  longest, "s", totalSamples(frozen), startsOf(evidence, frozen)}};
}

/// Values that stand still for a minute and more although the channel flickers at nearly every
/// sample elsewhere.
std::vector<Finding> findEntered(const Evidence& evidence, const Channel& channel) {
  constexpr double kShortest = 60.0;   // [s]
  constexpr std::size_t kFewest = 20;  // samples
  std::vector<IndexRange> runs = runsOf(evidence, channel, kFewest);
  const Flicker flicker = flickerOutside(channel, runs);
  runs = thoseWhere(std::move(runs),
                    [&](IndexRange run) { return durationOf(evidence, run) >= kShortest; });
  if (runs.empty() || !isNoisyOutside(channel, flicker)) return {};
  const IndexRange longest = *std::max_element(
      runs.begin(), runs.end(), [](IndexRange a, IndexRange b) { return a.size() < b.size(); });
  const double duration = durationOf(evidence, longest);
  return {Finding{"stuck", Severity::kNote,
                  std::string(channel.name) + " reads exactly " +
                      number(channel.values[longest.first]) + " " + channel.unit + " for " +
                      counted(longest.size(), "sample") + " (" + number(duration) +
                      " s), although it flickers by " + number(flicker.size) + " " + channel.unit +
                      " elsewhere; " + counted(totalSamples(runs), "sample") + " in " +
                      counted(runs.size(), "such place"),
                  "the value was probably set by hand rather than measured; fits and counted "
                  "charge take it as exact",
                  duration, "s", totalSamples(runs), startsOf(evidence, runs)}};
}

/// Median length of the runs of one value under load, when most runs have it; 1 otherwise.
std::size_t regularHold(const Evidence& evidence) {
  constexpr std::size_t kFewestRuns = 50;
  constexpr double kLongest = 50.0;
  constexpr double kRegularShare = 0.8;
  std::vector<double> lengths;
  for (const IndexRange& run : runsOf(evidence, evidence.current, 1))
    if (isUnderLoad(evidence, run.first)) lengths.push_back(static_cast<double>(run.size()));
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

double durationOf(const Evidence& evidence, IndexRange run) {
  return evidence.series.time[run.last - 1] - evidence.series.time[run.first];
}

std::vector<IndexRange> frozenRuns(const Evidence& evidence, const Channel& channel) {
  const Channel& other = otherThan(evidence, channel);
  return thoseWhere(runsOf(evidence, channel, std::max(kStuckSamples, 4 * evidence.hold)),
                    [&](IndexRange run) {
                      return reversalsDuring(evidence, other, run) >= kStuckReversals &&
                             !contains(channel.limits, channel.values[run.first]);
                    });
}

std::vector<double> provenLimits(const Evidence& evidence, const Channel& channel) {
  std::vector<double> limits;
  for (const double extreme : {channel.lowest, channel.highest})
    if (!clippedRuns(evidence, channel, extreme).empty()) limits.push_back(extreme);
  return limits;
}

std::vector<IndexRange> repeatedRuns(const Evidence& evidence) {
  std::vector<IndexRange> pairs = pairRuns(evidence);
  for (const Channel* channel : {&evidence.current, &evidence.voltage})
    pairs = thoseWhere(std::move(pairs), [&](IndexRange pair) {
      return !contains(channel->limits, channel->values[pair.first]);
    });
  const bool is_fast = evidence.interval < kPileUpInterval;
  for (const Channel* channel : {&evidence.current, &evidence.voltage}) {
    const bool flickers = is_fast ? flickersUnderLoad(evidence, *channel)
                                  : isNoisyOutside(*channel, flickerOutside(*channel, pairs));
    if (!flickers) return {};
  }
  const double current_share = shareThatGoesOnAlone(evidence, evidence.current);
  const double voltage_share = shareThatGoesOnAlone(evidence, evidence.voltage);
  if (std::max(current_share, voltage_share) > kMostlyStill) return {};
  const double chance = current_share * voltage_share;
  const auto samples = static_cast<double>(evidence.series.size());
  std::vector<IndexRange> repeated = thoseWhere(std::move(pairs), [&](IndexRange pair) {
    return samples * std::pow(chance, static_cast<double>(pair.size() - 1)) <= kChance;
  });
  for (IndexRange& pair : repeated) ++pair.first;
  return repeated;
}

std::vector<Finding> findQuantisation(const Evidence& evidence) {
  const Channel &voltage = evidence.voltage, &current = evidence.current;
  std::vector<Finding> findings;
  if (voltage.step && *voltage.step >= kCoarseVoltage * kAlmost)
    findings.push_back(
        coarseStep(voltage, kVeryCoarseVoltage,
                   "smaller differences between model and measurement mean nothing for a single "
                   "sample, and slow effects of a few mV show only in averages"));
  if (current.step && *current.step >= kCoarseCurrent * kAlmost)
    findings.push_back(
        coarseStep(current, kVeryCoarseCurrent,
                   "small currents, for example at rest, are no more certain than that"));
  return findings;
}

std::vector<Finding> findClipping(const Evidence& evidence) {
  std::vector<Finding> findings;
  for (const Channel* channel : {&evidence.current, &evidence.voltage})
    for (const double extreme : {channel->lowest, channel->highest}) {
      const std::vector<IndexRange> runs = clippedRuns(evidence, *channel, extreme);
      if (runs.empty()) continue;
      findings.push_back(
          Finding{"clipping", Severity::kWarning,
                  std::string(channel->name) + " is cut off at " + number(extreme) + " " +
                      channel->unit + ": " + counted(totalSamples(runs), "sample") + " in " +
                      counted(runs.size(), "place") + " read exactly that",
                  channel == &evidence.current
                      ? "the true current went beyond this value, so fits use these samples only "
                        "as bounds on the voltage and learn less about the resistance, and part of "
                        "the charge is not counted"
                      : "the true voltage went beyond this value, so fits leave these samples out",
                  extreme, channel->unit, totalSamples(runs), startsOf(evidence, runs)});
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

std::vector<Finding> findRepeated(const Evidence& evidence) {
  constexpr double kManyPercent = 0.5;
  const std::vector<IndexRange> repeated = repeatedRuns(evidence);
  if (repeated.empty()) return {};
  const double percent = 100.0 * static_cast<double>(totalSamples(repeated)) /
                         static_cast<double>(evidence.series.size());
  double longest = 0.0;
  for (const IndexRange& run : repeated)
    longest = std::max(longest, durationOf(evidence, {run.first - 1, run.last}));
  return {Finding{
      "stuck", percent >= kManyPercent ? Severity::kWarning : Severity::kNote,
      "current and voltage both repeat the previous sample under load, although both flicker: " +
          counted(repeated.size(), "time") + ", " + counted(totalSamples(repeated), "sample") +
          " (" + twoDigits(percent) + " %), the longest " + number(longest) + " s",
      "nothing was measured there (the last message was repeated); leave these samples out of fits "
      "and scores",
      longest, "s", totalSamples(repeated), startsOf(evidence, repeated)}};
}

std::size_t updateInterval(const Evidence& evidence) {
  if (!evidence.fast || !evidence.edges) return 1;
  const std::size_t hold = regularHold(evidence);
  return hold > 1 && movesWithoutCurrent(evidence) ? hold : 1;
}

}  // namespace battery_sof::check_parts
