#include "estimation/moved_charge.hpp"

#include <algorithm>
#include <cmath>

#include "util/constants.hpp"

namespace battery_sof {

MovedCharge movedCharge(const Series& series, IndexRange range) {
  const double max_gap = gapThreshold(series);
  MovedCharge moved;
  double charge = 0.0, least = 0.0, greatest = 0.0;
  for (std::size_t n = range.first + 1; n < range.last; ++n) {
    const double duration = series.time[n] - series.time[n - 1];
    if (duration > max_gap) continue;
    const double step = series.current[n] * duration / kSecondsPerHour;
    charge += step;
    moved.throughput += std::abs(step);
    least = std::min(least, charge);
    greatest = std::max(greatest, charge);
  }
  moved.span = greatest - least;
  return moved;
}

}  // namespace battery_sof
