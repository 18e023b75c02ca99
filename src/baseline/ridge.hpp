#pragma once

#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

/**
 * @brief Ridge regression of the voltage on currents and their memories, no physics and no state.
 *
 *     w = argmin sum (v - X w)^2 / n + lambda / 100 |w|^2   (the constant is free)
 *
 * Columns: phi(i) and low passes of it (time constants 0.1 to 3000 s by half decades, those between
 * 0.9 sampling intervals and a third of the span) for phi = i, max(i, 0), asinh(i / 5 A),
 * asinh(max(i, 0) / 2 A); charge; for time constants from 1 s on the recent discharge s as s0 / (s0
 * + s) and max(i, 0) s0 / (s0 + s), s0 = 5, 50, 500 As. Each is scaled by its mean and standard
 * deviation over the training range. lambda out of 1e-3 ... 1e4 by cross-validation over six
 * consecutive blocks. Of more than 20000 training rows every k-th is taken.
 *
 * @param train, test  ranges of series; memories run from the first sample of both to the last.
 * @return [V], one a sample of test; uses no voltage but those of train.
 * @throws std::invalid_argument when a range is empty or outside the series, or train has fewer
 * than 60 samples.
 */
std::vector<double> ridgeVoltage(const Series& series, IndexRange train, IndexRange test);

}  // namespace battery_sof
