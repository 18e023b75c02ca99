#pragma once

#include "model/simulation.hpp"
#include "prediction/answer.hpp"

namespace battery_sof {

/// 95 % quantile of the standard normal distribution: half-width of a 90 % interval in standard
/// deviations.
inline constexpr double kNinetyPercent = 1.6448536269514722;

/**
 * @brief Terminal voltage with its 90 % interval from parameters, state and the model's own error
 * together.
 *
 *     var = sum_k (du / d tangent_k)^2 + sigma_m^2
 *
 * @param simulation  of uncertainSimulationOf(), so that the tangents' squares sum to a variance.
 * @param model_error sigma_m [V], what the model misses even with the right parameters.
 */
Interval voltageInterval(const Simulation& simulation, double model_error);

}  // namespace battery_sof
