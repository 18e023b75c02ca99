#pragma once

#include <optional>

#include "battery_sof/identify/fitted_model.hpp"
#include "battery_sof/predict/answer.hpp"

namespace battery_sof {

/**
 * @brief A crank's lowest voltage, the equations' corrected by the cranks that passed.
 *
 *     u_1 = u_m + w_1' f(i),   u_2 = line(i) + w_2' f(i),   f = [1, clipped, (1 - clipped) (i + 200 A) / 100 A]
 *     u = (u_1 + u_2) / 2 with four past cranks or more, else u_1
 *
 * w by ridge regression (penalty 0.3) on what equations and the naive line missed of past cranks. clipped: the sensor's end of
 * range, where several past cranks stand; what the terminals see below it is not known. The interval is that of leaving each
 * past crank out, at least three of them; the equations' own otherwise.
 *
 * @param current  lowest of the crank [A].   @param modelled [V], by the equations, with its interval.
 */
Interval experiencedCrank(const FittedModel& model, double current, const Interval& modelled);

/**
 * @brief Mean current of a charge's beginning, from model and past charges by what each missed so far.
 *
 *     i = w i_m + (1 - w) median,   w = a^-2 / (a^-2 + b^-2)
 *
 * a, b [A]: median errors over the past charges of that duration, of the model and of the median of the others; at least three charges
 * whose mean voltage was within 0.5 V, else the model alone. The interval is that of past errors of the same mean.
 *
 * @param voltage held [V].   @param duration [s]; past charges count that lasted up to twice or down to half as long.
 * @param modelled [A], of the model, with its interval.
 */
Interval experiencedCharge(const FittedModel& model, double voltage, double duration, const Interval& modelled);

/// What past charges say of a model's answer at a voltage and over a duration.
struct ChargeEvidence {
  int charges = 0;           ///< that lasted alike, at a voltage within 0.3 V
  double median_error = 0.0; ///< [A], of the model
  double typical = 0.0;      ///< [A], median current
  bool vouches = false;      ///< three or more, median error at most a quarter of the typical current or 1 A
};

ChargeEvidence chargeEvidence(const Experience& experience, double voltage, double duration);

}  // namespace battery_sof
