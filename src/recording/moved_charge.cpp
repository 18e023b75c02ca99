#include "recording/moved_charge.hpp"

#include <algorithm>
#include <cmath>

#include "util/constants.hpp"

namespace battery_sof {

double chargeOfStep(const Series& series, std::size_t n, double max_gap) {
  const double duration = series.time[n] - series.time[n - 1];
  if (duration > max_gap) return 0.0;
  return 0.5 * (series.current[n - 1] + series.current[n]) * duration / kSecondsPerHour;
}

MovedCharge movedCharge(const Series& series, IndexRange range, std::optional<double> max_gap) {
  const double joined = max_gap ? *max_gap : gapThreshold(series);
  MovedCharge moved;
  double charge = 0.0, least = 0.0, greatest = 0.0;
  for (std::size_t n = range.first + 1; n < range.last; ++n) {
    const double step = chargeOfStep(series, n, joined);
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

}  // namespace battery_sof
