#include <algorithm>
#include <cmath>

#include "check_parts.hpp"
#include "recording/channel_statistics.hpp"

/// Findings about one channel's values, judged by what the other channel does meanwhile.
namespace battery_sof::check_parts {
namespace {

constexpr double kCoarseVoltage = 0.005;     // [V], a crank's drop of 2 V in 400 steps
constexpr double kVeryCoarseVoltage = 0.05;  // [V]
// [A], the least current offset worth finding (docs/physics.md#current_offset)
constexpr double kCoarseCurrent = 0.05;
constexpr double kVeryCoarseCurrent = 1.0;  // [A]
constexpr double kAlmost = 1.0 - 1e-3;      // of a limit: printed steps are rounded

std::vector<double> startsOf(const Evidence& evidence, const std::vector<IndexRange>& runs) {
  std::vector<double> starts;
  for (const IndexRange& run : runs) starts.push_back(evidence.series.time[run.first]);
  return someTimes(starts);
}

// ---------------------------------------------------------------------------------------------
// quantisation

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

// ---------------------------------------------------------------------------------------------
// stuck values

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
                      " is not measured there (sensor asleep, or its last message repeated); leave "
                      "these stretches out",
                  longest, "s", totalSamples(frozen), startsOf(evidence, frozen)}};
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
  const IndexRange longest = *std::max_element(
      runs.begin(), runs.end(), [](IndexRange a, IndexRange b) { return a.size() < b.size(); });
  const double duration = durationOf(evidence, longest);
  return {Finding{
      "stuck", Severity::kNote,
      std::string(channel.name) + " reads exactly " + number(channel.values[longest.first]) + " " +
          channel.unit + " for " + counted(longest.size(), "sample") + " (" + number(duration) +
          " s), though it flickers by " + number(flicker.size) + " " + channel.unit +
          " elsewhere; " + counted(totalSamples(runs), "sample") + " in " +
          counted(runs.size(), "such place"),
      "set or entered there rather than measured; fits and counted charge take it as exact",
      duration, "s", totalSamples(runs), startsOf(evidence, runs)}};
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
  const Channel &voltage = evidence.voltage, &current = evidence.current;
  std::vector<Finding> findings;
  if (voltage.step && *voltage.step >= kCoarseVoltage * kAlmost)
    findings.push_back(
        coarseStep(voltage, kVeryCoarseVoltage,
                   "differences between model and measurement below that say nothing sample by "
                   "sample, and slow effects of a few mV show only in averages"));
  if (current.step && *current.step >= kCoarseCurrent * kAlmost)
    findings.push_back(coarseStep(current, kVeryCoarseCurrent,
                                  "small rest and float currents are known no better"));
  return findings;
}

std::vector<Finding> findClipping(const Evidence& evidence) {
  std::vector<Finding> findings;
  for (const Channel* channel : {&evidence.current, &evidence.voltage})
    for (const double extreme : {channel->lowest, channel->highest}) {
      const std::vector<IndexRange> runs = clippedRuns(evidence, *channel, extreme);
      if (runs.empty()) continue;
      findings.push_back(Finding{
          "clipping", Severity::kWarning,
          std::string(channel->name) + " is cut off at " + number(extreme) + " " + channel->unit +
              ": " + counted(totalSamples(runs), "sample") + " in " +
              counted(runs.size(), "place") + " read exactly that",
          channel == &evidence.current
              ? "the true current lay beyond: fits keep these samples, so their resistances come "
                "out too large, and charge is missing"
              : "the true voltage lay beyond: fits leave these samples out",
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
    longest =
        std::max(longest, evidence.series.time[run.last - 1] - evidence.series.time[run.first - 1]);
  return {Finding{
      "stuck", percent >= kManyPercent ? Severity::kWarning : Severity::kNote,
      "current and voltage both repeat the sample before under load, though both flicker: " +
          counted(repeated.size(), "time") + ", " + counted(totalSamples(repeated), "sample") +
          " (" + twoDigits(percent) + " %), the longest " + number(longest) + " s",
      "nothing is measured there (the last message repeated); leave these samples out of fits and "
      "of scores",
      longest, "s", totalSamples(repeated), startsOf(evidence, repeated)}};
}

std::size_t updateInterval(const Evidence& evidence) {
  if (!evidence.fast || !evidence.edges) return 1;
  const std::size_t hold = regularHold(evidence);
  return hold > 1 && movesWithoutCurrent(evidence) ? hold : 1;
}

}  // namespace battery_sof::check_parts
