#include "check_parts.hpp"

#include <algorithm>
#include <cmath>

#include "recording/channel_statistics.hpp"
#include "util/text.hpp"

namespace battery_sof::check_parts {
namespace {

constexpr double kNoiseSigmas = 9.0;  // 6.4 sigma of a difference: no move by chance in 1e9 samples
constexpr double kMoveSteps = 2.5;    // quantisation alone moves by one step, with noise by two
// of what the largest current does to the other channel: a current sensor's error
constexpr double kMoveShare = 0.02;
constexpr double kMoveDuration = 0.05;   // [s], over which a move is taken; shorter than a crank
constexpr std::size_t kFlatSamples = 3;  // docs/physics.md#clipping
constexpr double kFlatDuration = 5.0;    // [s], a crank lasts no longer
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
constexpr double kFlickerShare = 0.1;  // of the recording
constexpr double kChance = 1e-3;       // of one false claim in the whole recording

/// How often another channel turns round during a run, but for the samples at its ends in which a
/// shift between the channels shows the neighbours' edges.
std::size_t reversalsDuring(const Evidence& evidence, const Channel& other, IndexRange run) {
  if (evidence.edges && evidence.interval > 0.0) {
    const auto lag =
        static_cast<std::size_t>(std::ceil(std::abs(evidence.edges->lag) / evidence.interval));
    run = run.size() <= 2 * lag ? IndexRange{run.first, run.first}
                                : IndexRange{run.first + lag, run.last - lag};
  }
  const Move move = realMove(evidence, other);
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

/// Whether two samples are of one reading, as far as the values tell.
bool repeats(const Channel& channel, std::size_t k) {
  return channel.values[k] == channel.values[k - 1];
}

/// Share of tries that succeed, by Laplace's rule of succession.
double laplaceShare(std::size_t successes, std::size_t tries) {
  return static_cast<double>(successes + 1) / static_cast<double>(tries + 2);
}

/// Share of a channel's repetitions under load, away from its limits, that another one follows. Of
/// white noise it is the chance of a repetition, of values that somebody holds it is nearly 1.
double shareThatGoesOn(const Evidence& evidence, const Channel& channel) {
  std::size_t begun = 0, gone_on = 0;
  for (std::size_t k = 2; k < channel.values.size(); ++k) {
    const bool is_limit =
        channel.values[k - 1] == channel.lowest || channel.values[k - 1] == channel.highest;
    if (is_limit || !isUnderLoad(evidence, k) || !repeats(channel, k - 1)) continue;
    ++begun;
    if (repeats(channel, k)) ++gone_on;
  }
  return laplaceShare(gone_on, begun);
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
  std::vector<IndexRange> tops;
  for (const IndexRange& run : runsOf(evidence, channel, kFlatSamples)) {
    if (!isAtExtreme(channel, run, extreme) || durationOf(evidence, run) > kFlatDuration) continue;
    const double chance = std::pow(share, static_cast<double>(run.size() - 2));
    if (static_cast<double>(channel.values.size()) * chance < kChance) tops.push_back(run);
  }
  if (tops.size() == 1 && !isApproachedSteeply(evidence, channel, tops.front())) tops.clear();
  return tops;
}

/// Separate samples that share one extreme current, though the currents below it, from half of it
/// on, are scattered and the voltages differ.
std::vector<IndexRange> pileUp(const Evidence& evidence, double extreme) {
  if (evidence.interval < kPileUpInterval || !evidence.edges) return {};
  std::vector<IndexRange> runs;
  std::vector<double> voltages, crowd;
  for (const IndexRange& run : runsOf(evidence, evidence.current, 1)) {
    if (!isAtExtreme(evidence.current, run, extreme)) continue;
    runs.push_back(run);
    voltages.push_back(evidence.series.voltage[run.first]);
  }
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
  std::vector<IndexRange> pairs;
  for (const IndexRange& run : runsOf(evidence, evidence.current, 2)) {
    if (!isUnderLoad(evidence, run.first)) continue;
    const auto found = constantRuns(evidence.voltage.values, run, 2);
    pairs.insert(pairs.end(), found.begin(), found.end());
  }
  return pairs;
}

/// Share of a channel's repetitions under load that another one follows while the other channel
/// moves: what a repeated message is, is not counted.
double shareThatGoesOnAlone(const Evidence& evidence, const Channel& channel) {
  const Channel& other = otherThan(evidence, channel);
  std::size_t begun = 0, gone_on = 0, samples = 0, repeated = 0;
  for (std::size_t k = 2; k < channel.values.size(); ++k) {
    if (!isUnderLoad(evidence, k) || repeats(other, k)) continue;
    ++samples;
    if (repeats(channel, k)) ++repeated;
    if (!repeats(channel, k - 1) || repeats(other, k - 1)) continue;
    ++begun;
    if (repeats(channel, k)) ++gone_on;
  }
  // Of rare repetitions too few begin to tell how they go on.
  constexpr std::size_t kEnough = 30;
  return begun >= kEnough ? laplaceShare(gone_on, begun) : laplaceShare(repeated, samples);
}

}  // namespace

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

std::vector<IndexRange> clippedRuns(const Evidence& evidence, const Channel& channel,
                                    double extreme) {
  std::vector<IndexRange> runs = flatTops(evidence, channel, extreme);
  std::vector<IndexRange> silent = silentTops(evidence, channel, extreme);
  if (silent.size() > runs.size()) runs = std::move(silent);
  if (&channel != &evidence.current) return runs;
  std::vector<IndexRange> piled = pileUp(evidence, extreme);
  return piled.size() > runs.size() ? piled : runs;
}

std::vector<IndexRange> frozenRuns(const Evidence& evidence, const Channel& channel) {
  const Channel& other = otherThan(evidence, channel);
  const std::vector<double> limits = provenLimits(evidence, channel);
  std::vector<IndexRange> frozen =
      runsOf(evidence, channel, std::max(kStuckSamples, 4 * evidence.hold));
  frozen.erase(std::remove_if(frozen.begin(), frozen.end(),
                              [&](const IndexRange& run) {
                                return reversalsDuring(evidence, other, run) < kStuckReversals ||
                                       contains(limits, channel.values[run.first]);
                              }),
               frozen.end());
  return frozen;
}

std::vector<double> provenLimits(const Evidence& evidence, const Channel& channel) {
  std::vector<double> limits;
  for (const double extreme : {channel.lowest, channel.highest})
    if (!clippedRuns(evidence, channel, extreme).empty()) limits.push_back(extreme);
  return limits;
}

std::vector<IndexRange> repeatedRuns(const Evidence& evidence) {
  std::vector<IndexRange> pairs = pairRuns(evidence);
  for (const Channel* channel : {&evidence.current, &evidence.voltage}) {
    const std::vector<double> limits = provenLimits(evidence, *channel);
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                               [&](const IndexRange& pair) {
                                 return contains(limits, channel->values[pair.first]);
                               }),
                pairs.end());
  }
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
  std::vector<IndexRange> repeated;
  for (const IndexRange& pair : pairs) {
    const auto repeats = static_cast<double>(pair.size() - 1);
    if (samples * std::pow(chance, repeats) > kChance) continue;
    repeated.push_back({pair.first + 1, pair.last});
  }
  return repeated;
}

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

bool isNoisyOutside(const Channel& channel, const Flicker& flicker) {
  constexpr double kMinFlicker = 1e-5;  // of the largest value; less is rounding of computed data
  const double largest = std::max(std::abs(channel.lowest), std::abs(channel.highest));
  return flicker.samples > kFlickerShare * channel.values.size() && flicker.turning > kTurning &&
         flicker.size >= kMinFlicker * largest &&
         flicker.size >= kMoveSteps * channel.step.value_or(0.0);
}

}  // namespace battery_sof::check_parts
