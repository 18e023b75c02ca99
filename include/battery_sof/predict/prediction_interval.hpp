#pragma once

#include "battery_sof/identify/fitted_model.hpp"
#include "battery_sof/model/base_model.hpp"
#include "battery_sof/predict/answer.hpp"

namespace battery_sof {

/// 95 % quantile of the standard normal distribution: half-width of a 90 % interval in standard deviations.
inline constexpr double kNinetyPercent = 1.6448536269514722;

/**
 * @brief Terminal voltage with its 90 % interval from parameters, state and the model's own error together.
 *
 *     var = g' V g + sigma_m^2,   g = d u / d (r_discharge, r_charge, c2, beta, u_dc, u_c2 at the saved state)
 *
 * @param overpotential state with derivatives counted from the model's saved state.
 * @param model_error   sigma_m [V], what the model misses even with the right parameters.
 */
Interval voltageInterval(const FittedModel& model, double current,
                         const Overpotential& overpotential, double model_error);

}  // namespace battery_sof
