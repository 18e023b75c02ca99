#include "estimation/moved_charge.hpp"

#include <algorithm>
#include <cmath>

#include "util/constants.hpp"

namespace battery_sof {
namespace {

constexpr double kSmallCurrent = 0.002;  // of a capacity's current of an hour: a sensor's zero
constexpr double kBeginningShare = 0.1;  // of what a discharge draws

/// [Ah], over the step to a sample; none over a gap.
double chargeOfStep(const Series& series, std::size_t n, double max_gap) {
  const double duration = series.time[n] - series.time[n - 1];
  return duration > max_gap ? 0.0 : series.current[n] * duration / kSecondsPerHour;
}

}  // namespace

std::vector<std::string> MovedCharge::physicsOfDepth(double capacity, bool is_controlled) const {
  if (!isDeep(capacity)) return {};
  std::vector<std::string> effects = {kMovedByCharge};
  if (is_controlled && isChargedDeep(capacity)) effects.push_back(kFilledUp);
  if (isDrawnDeep(capacity)) effects.push_back(kUsedUp);
  return effects;
}

MovedCharge movedCharge(const Series& series, IndexRange range) {
  const double max_gap = gapThreshold(series);
  MovedCharge moved;
  double charge = 0.0, least = 0.0, greatest = 0.0;
  for (std::size_t n = range.first + 1; n < range.last; ++n) {
    const double step = chargeOfStep(series, n, max_gap);
    charge += step;
    moved.throughput += std::abs(step);
    least = std::min(least, charge);
    greatest = std::max(greatest, charge);
    moved.drawn = std::max(moved.drawn, greatest - charge);
    moved.charged = std::max(moved.charged, charge - least);
  }
  moved.span = greatest - least;
  return moved;
}

std::optional<IndexRange> dischargeUnderWay(const Series& series, IndexRange searched,
                                            double capacity) {
  const double charging = kSmallCurrent * capacity;
  if (searched.size() < 2 || series.current[searched.last - 1] > -charging) return std::nullopt;
  std::size_t first = searched.last - 1;
  while (first > searched.first && series.current[first - 1] <= charging) --first;
  const double drawn = movedCharge(series, {first, searched.last}).span;
  if ((1.0 - kBeginningShare) * drawn < kDeepShare * capacity) return std::nullopt;
  const double max_gap = gapThreshold(series);
  double beginning = kBeginningShare * drawn;
  std::size_t begin = first;
  while (beginning > 0.0 && begin + 1 < searched.last)
    beginning += chargeOfStep(series, ++begin, max_gap);
  return IndexRange{begin, searched.last};
}

}  // namespace battery_sof
