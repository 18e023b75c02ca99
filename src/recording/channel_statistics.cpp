#include "recording/channel_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kMaxChanges = 100000;  // enough to see a step in; keeps long files quick
constexpr std::size_t kFewestChanges = 30;
constexpr std::size_t kFewestLevels = 8;
constexpr double kTolerance = 0.08;      // of a step
constexpr double kLooseTolerance = 0.2;  // of a step, while it is being refined
constexpr double kNearlyAll = 0.95;
constexpr double kFewestSingleSteps = 0.02;  // share of changes by exactly one step
// beyond it an error of the step adds up to the tolerance
constexpr double kLargestMultiple = 30.0;
// |z| below which a quarter of a normal distribution lies
constexpr double kNormalQuartile = 0.31863936;

/// Sizes of the changes from sample to sample, zeros left out, thinned to kMaxChanges, in rising
/// order. @param held of another channel, whose value repeats, or none.
std::vector<double> sortedChanges(const std::vector<double>& values,
                                  const std::vector<double>* held = nullptr) {
  std::vector<double> changes;
  const std::size_t stride = 1 + values.size() / kMaxChanges;
  for (std::size_t k = 1; k < values.size(); k += stride) {
    if (held && (*held)[k] != (*held)[k - 1]) continue;
    const double change = std::abs(values[k] - values[k - 1]);
    if (change > 1e-9 * std::abs(values[k])) changes.push_back(change);
  }
  std::sort(changes.begin(), changes.end());
  return changes;
}

/// Middles of the clusters of the smallest changes: the steps the channel itself suggests.
std::vector<double> candidateSteps(const std::vector<double>& changes) {
  constexpr std::size_t kMaxCandidates = 40;
  constexpr double kClusterWidth = 1.2;
  std::vector<double> candidates;
  auto first = changes.begin();
  while (first != changes.end() && candidates.size() < kMaxCandidates) {
    const auto last = std::upper_bound(first, changes.end(), kClusterWidth * *first);
    const auto size = static_cast<std::size_t>(last - first);
    if (size > kFewestSingleSteps * changes.size()) candidates.push_back(*(first + size / 2));
    first = last;
  }
  return candidates;
}

/// Least-squares step through the multiples it is thought to have, within the first few where they
/// are beyond doubt.
double refineStep(const std::vector<double>& changes, double step) {
  for (const double largest : {3.0, 10.0, kLargestMultiple}) {
    double products = 0.0, squares = 0.0;
    for (const double change : changes) {
      const double multiple = std::round(change / step);
      if (multiple < 1.0 || multiple > largest) continue;
      if (std::abs(change / step - multiple) > kLooseTolerance) continue;
      products += multiple * change;
      squares += multiple * multiple;
    }
    if (squares > 0.0) step = products / squares;
  }
  return step;
}

bool fits(const std::vector<double>& changes, double step) {
  std::size_t judged = 0, fitting = 0, single = 0;
  for (const double change : changes) {
    const double multiple = std::round(change / step);
    if (multiple > kLargestMultiple) break;
    ++judged;
    if (multiple < 1.0 || std::abs(change / step - multiple) > kTolerance) continue;
    ++fitting;
    if (multiple == 1.0) ++single;
  }
  return judged >= kFewestChanges && fitting >= kNearlyAll * judged &&
         single >= kFewestSingleSteps * judged;
}

bool usesEnoughLevels(const std::vector<double>& values, double step) {
  std::vector<double> levels;
  for (const double value : values) {
    const double level = std::round(value / step);
    if (contains(levels, level)) continue;
    levels.push_back(level);
    if (levels.size() == kFewestLevels) return true;
  }
  return false;
}

std::optional<double> stepOf(const std::vector<double>& changes,
                             const std::vector<double>& values) {
  if (changes.size() < kFewestChanges) return std::nullopt;
  std::optional<double> greatest;
  for (const double candidate : candidateSteps(changes)) {
    const double step = refineStep(changes, candidate);
    if (fits(changes, step)) greatest = std::max(step, greatest.value_or(0.0));
  }
  if (greatest && !usesEnoughLevels(values, *greatest)) return std::nullopt;
  return greatest;
}

}  // namespace

std::optional<double> findStep(const std::vector<double>& values) {
  return stepOf(sortedChanges(values), values);
}

std::optional<double> findVoltageStep(const Series& series) {
  const std::vector<double>& values = series.voltage;
  return std::max(findStep(values), stepOf(sortedChanges(values, &series.current), values));
}

double noiseLevel(const std::vector<double>& values, std::optional<double> step) {
  const double floor = step.value_or(0.0) / std::sqrt(12.0);
  if (values.size() < 2) return 0.0;
  std::vector<double> changes(values.size() - 1);
  std::transform(values.begin() + 1, values.end(), values.begin(), changes.begin(),
                 [](double later, double earlier) { return std::abs(later - earlier); });
  return std::max(floor, quantile(std::move(changes), 0.25) / kNormalQuartile / std::sqrt(2.0));
}

std::vector<IndexRange> constantRuns(const std::vector<double>& values,
                                     const std::vector<IndexRange>& ranges,
                                     std::size_t min_samples) {
  const auto repeats = [&](std::size_t k) { return values[k] == values[k - 1]; };
  std::vector<IndexRange> runs;
  for (const IndexRange& range : ranges)
    for (const IndexRange& run : cutWhere(range, repeats))
      if (run.size() >= min_samples) runs.push_back(run);
  return runs;
}

std::size_t countReversals(const std::vector<double>& values, IndexRange range, std::size_t stride,
                           double threshold) {
  if (range.size() < 3) return 0;
  stride = std::clamp<std::size_t>((range.size() - 1) / 2, 1, stride);
  std::size_t reversals = 0;
  double direction = 0.0;
  for (std::size_t k = range.first; k + stride < range.last; ++k) {
    const double move = values[k + stride] - values[k];
    if (std::abs(move) < threshold) continue;
    if (move * direction < 0.0) ++reversals;
    direction = move;
  }
  return reversals;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto nth = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

double medianOf(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

}  // namespace battery_sof
