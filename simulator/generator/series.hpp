#pragma once

#include <cstddef>
#include <vector>

namespace battery_sof_simulator {

/// A series between two entries by a straight line; the ends are held. @param position in entries.
double valueAt(const std::vector<double>& series, double position);

/// The value that a share of all lie below; 0 of none.
double quantile(std::vector<double> values, double share);

/// Knots joined by straight lines, per_knot entries apart.
std::vector<double> joined(const std::vector<double>& knots, std::size_t per_knot);

/**
 * @brief A current as a recording's samples know it: means around each sample, linear between.
 *
 * What a recording of these samples leaves unknown between them is then nothing.
 *
 * @param per_sample entries of `current` a sample, >= 1.
 */
std::vector<double> linearBetweenSamples(const std::vector<double>& current,
                                         std::size_t per_sample);

}  // namespace battery_sof_simulator
