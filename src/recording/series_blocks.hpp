#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "battery_sof/series.hpp"
#include "util/text.hpp"

namespace battery_sof {

// A battery of n blocks of 12 V in series (0.5 for 6 V, 2 for 24 V, 4 for 48 V) is treated as one
// block, the mean of them: voltages are divided by n where they come in and multiplied by n where
// they go out. What lies between, bounds and limits too, is of one block.

/**
 * @brief How many 12 V blocks in series a voltage is that of: 1 for 12 V, 2 for 24 V, 4 for 48 V;
 * never below 1.
 *
 * For a battery that was not said to be a row: limits in volts are those of one block; errors and
 * voltages of a row of n blocks are n times as large.
 * @param voltage of a battery at rest [V]: 11.3 to 13.2 V a block are counted right up to four
 * blocks.
 */
inline double seriesBlocksAt(double voltage) {
  constexpr double kRestOfBlock = 12.5;  // [V], between a full and a half empty one
  return std::max(1.0, std::round(voltage / kRestOfBlock));
}

// [V] of a block, between which it stays but for seconds
inline constexpr double kLowestBlock = 10.5;   // 1.75 V a cell: discharged under load
inline constexpr double kHighestBlock = 15.5;  // 2.58 V a cell: end of charge without voltage limit

/// @return the usual number of blocks in series whose voltage this can be, most of the time [V], and
/// how it is said, e.g. "2 blocks of 12 V in series"; 0 where it is that of none.
inline std::pair<double, std::string> seriesThatFits(double voltage) {
  for (const double blocks : {1.0, 2.0, 3.0, 4.0, 0.5}) {
    const double each = voltage / blocks;
    if (each < kLowestBlock || each > kHighestBlock) continue;
    if (blocks < 1.0) return {blocks, "half a block, a battery of 6 V"};
    if (blocks == 1.0) return {blocks, "one block of 12 V"};
    return {blocks, format("%g blocks of 12 V in series", blocks)};
  }
  return {};
}

inline constexpr double kMinSeriesBlocks = 0.5, kMaxSeriesBlocks = 6.0;

/// Whether a number of blocks is one that can be asked for.
inline bool areSeriesBlocks(double series_blocks) {
  return series_blocks >= kMinSeriesBlocks && series_blocks <= kMaxSeriesBlocks &&
         std::round(2.0 * series_blocks) == 2.0 * series_blocks;
}

/// What can be asked for, in words that fit behind "expected".
inline constexpr char kAllowedSeriesBlocks[] =
    "0.5 (6 V), 1 (12 V), 2 (24 V), 4 (48 V) or another multiple of 0.5 up to 6";

/// What results in volts and ohms are of, where they are not of the whole row. No full stop.
inline std::string seriesBlocksSentence(double series_blocks) {
  return format(
      "%g blocks of 12 V in series: volts and ohms reported here are those of one block, the "
      "battery's are %g times as large",
      series_blocks, series_blocks);
}

/// @return the series with the voltage of one block of a row.
inline Series perBlock(Series series, double series_blocks) {
  for (double& voltage : series.voltage) voltage /= series_blocks;
  return series;
}

}  // namespace battery_sof
