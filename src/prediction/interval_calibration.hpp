#pragma once

#include "estimation/fitted_model.hpp"
#include "prediction/answer.hpp"

namespace battery_sof {

/**
 * @brief Updates from an event how wide its kind of interval must be: adaptive conformal inference
 * (Gibbs and Candes 2021) on the logarithm of the width.
 *
 *     outside: factor <- factor e^(0.9 eta),   inside: factor <- factor e^(-0.1 eta),   eta = 0.25
 *
 * The share inside tends to 90 % for any sequence of events, calibrated model or not: over n events
 * it is off by at most
 * |ln(last factor / first factor)| / (eta n). The factor stays in [0.1, 50].
 */
void update(IntervalCalibration& scale, double measured, const Interval& expected);

}  // namespace battery_sof
