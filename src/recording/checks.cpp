#include "recording/checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <string>

#include "check_parts.hpp"
#include "recording/channel_statistics.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace check_parts {
namespace {

using Part = std::vector<Finding> (*)(const Evidence&);

constexpr Part kParts[] = {
    findVoltageLevel, findDeepDischarge, findSign,       findTimeUnit, findExcitation,
    findSlowRate,     findUnevenRate,    findHeldValues, findSkew,     findStuck,
    findRepeated,     findClipping,      findRefused,    findLost,     findClock,
    findGaps,         findQuantisation,  findOffset,     findAliasing, findImpossibleTemperatures};

/// Those that find problems; they need no more than the series.
constexpr Part kProblemParts[] = {findVoltageLevel, findSign, findTimeUnit, findExcitation};

constexpr double kFastInterval = 0.05;  // [s], 20 Hz
constexpr double kFewestSigmas = 12.0;  // noise alone spans 9 sigma in 1e5 samples
constexpr double kClearCorrelation = 0.5;

Channel describeChannel(const char* name, const char* unit, const std::vector<double>& values,
                        std::optional<double> step) {
  const auto [lowest, highest] = std::minmax_element(values.begin(), values.end());
  return {name, unit, values, step, noiseLevel(values, step), *lowest, *highest};
}

bool isExcited(const Evidence& evidence) {
  if (evidence.edges && std::abs(evidence.edges->correlation) >= kClearCorrelation) return true;
  const Channel& current = evidence.current;
  const double range = current.highest - current.lowest;
  return range > 0.0 && range > kFewestSigmas * current.noise &&
         range > 3.0 * current.step.value_or(0.0);
}

}  // namespace

Evidence::Evidence(const Series& s, const Recording* r)
    : series(s),
      recording(r),
      interval(medianInterval(series)),
      stretches(contiguousRanges(series, gapThreshold(series))),
      current(describeChannel("current", "A", series.current, findStep(series.current))),
      voltage(describeChannel("voltage", "V", series.voltage, findVoltageStep(series))),
      largest_current(std::max(std::abs(current.lowest), std::abs(current.highest))),
      edges(edgeResponse(series)),
      excited(isExcited(*this)),
      fast(interval <= kFastInterval) {
  hold = updateInterval(*this);
  for (Channel* channel : {&current, &voltage}) channel->limits = provenLimits(*this, *channel);
}

std::vector<double> someTimes(const std::vector<double>& times) {
  constexpr std::size_t kMost = 10;
  if (times.size() <= kMost) return times;
  std::vector<double> some(kMost);
  for (std::size_t k = 0; k < kMost; ++k) some[k] = times[k * (times.size() - 1) / (kMost - 1)];
  return some;
}

std::vector<double> startsOf(const Evidence& evidence, const std::vector<IndexRange>& ranges) {
  std::vector<double> starts;
  for (const IndexRange& range : ranges) starts.push_back(evidence.series.time[range.first]);
  return someTimes(starts);
}

std::size_t totalSamples(const std::vector<IndexRange>& ranges) {
  std::size_t samples = 0;
  for (const IndexRange& range : ranges) samples += range.size();
  return samples;
}

std::string number(double value) {
  const bool is_large = std::abs(value) >= 1e3 && std::abs(value) < 1e9;
  return format(is_large ? "%.0f" : "%.4g", value);
}

std::string twoDigits(double value) { return format("%.2g", value); }

std::string counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace check_parts

std::string toString(Severity severity) {
  constexpr std::array kNames = {"note", "warning", "problem"};
  return kNames.at(static_cast<std::size_t>(severity));
}

CheckReport checkRecording(const Recording& recording, std::optional<double> crank_current) {
  if (recording.series.empty())
    throw std::invalid_argument("checkRecording: " + recording.name + " has no sample");
  check_parts::Evidence evidence(recording.series, &recording);
  CheckReport report;
  report.crank = crankCurrentOf(recording.series, crank_current);
  evidence.crank_current = report.crank.current;
  report.samples = recording.series.size();
  report.from = recording.series.time.front();
  report.to = recording.series.time.back();
  report.median_interval = evidence.interval;
  report.voltage_lsb = evidence.voltage.step;
  report.current_lsb = evidence.current.step;
  for (const check_parts::Part part : check_parts::kParts) {
    std::vector<Finding> found = part(evidence);
    std::move(found.begin(), found.end(), std::back_inserter(report.findings));
  }
  std::stable_sort(report.findings.begin(), report.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
  report.not_judged = check_parts::listNotJudged(evidence);
  return report;
}

/// @param recording none: nothing is known of what its reader refused.
static std::vector<Finding> problemsOf(const Series& series, const Recording* recording) {
  std::vector<Finding> problems;
  if (series.empty()) return problems;
  const check_parts::Evidence evidence(series, recording);
  const auto add = [&](std::vector<Finding> findings) {
    for (Finding& finding : findings)
      if (finding.severity == Severity::kProblem) problems.push_back(std::move(finding));
  };
  for (const check_parts::Part part : check_parts::kProblemParts) add(part(evidence));
  if (recording) add(check_parts::findRefused(evidence));
  return problems;
}

std::vector<Finding> findProblems(const Series& series) { return problemsOf(series, nullptr); }

std::vector<Finding> findProblems(const Recording& recording) {
  return problemsOf(recording.series, &recording);
}

std::string format(const std::vector<Finding>& problems) {
  std::string text;
  for (const Finding& problem : problems)
    text += (text.empty() ? "" : "; ") + problem.what + ": " + problem.meaning;
  return text;
}

}  // namespace battery_sof
