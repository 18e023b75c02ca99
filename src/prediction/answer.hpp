#pragma once

#include "battery_sof/queries.hpp"

namespace battery_sof {

/// @return a voltage of one block, of a row of them [V].
inline Interval ofSeries(const Interval& of_one, double series_blocks) {
  return {series_blocks * of_one.value, series_blocks * of_one.lower, series_blocks * of_one.upper};
}

}  // namespace battery_sof
