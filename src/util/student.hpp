#pragma once

namespace battery_sof {

/**
 * @brief Quantile of Student's t distribution (Boost.Math).
 *
 * @param probability (0, 1).
 * @param degrees of freedom, above 0; need not be whole.
 * @throws std::invalid_argument outside these ranges.
 */
double studentQuantile(double probability, double degrees);

}  // namespace battery_sof
