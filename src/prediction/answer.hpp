#pragma once

#include "battery_sof/queries.hpp"

namespace battery_sof {

/// @return a voltage of one block, of a row of them [V].
inline Interval ofSeries(const Interval& of_one, double series_blocks) {
  return {series_blocks * of_one.value, series_blocks * of_one.lower, series_blocks * of_one.upper};
}

/// 95 % quantile of the standard normal distribution: half-width of a 90 % interval in standard
/// deviations.
inline constexpr double kNinetyPercent = 1.6448536269514722;

/// @return the 90 % interval of a normal number. @param factor on its width.
inline Interval ninetyPercent(double value, double std, double factor = 1.0) {
  const double half = kNinetyPercent * factor * std;
  return {value, value - half, value + half};
}

}  // namespace battery_sof
