#pragma once

#include "battery_sof/series.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/// A recording with the model that was fitted to it.
struct Modelled {
  Series series;
  FittedModel model;
};

/**
 * @brief How much worse each model is on the other's recording than that recording's own one.
 *
 *     median of ln(e_other / e_own) over eight blocks of both recordings
 *
 * e^2 is the mean squared error of a block in units of the variance of the quantity that responds
 * there. The median, because a battery in other conditions for an hour is no other battery.
 *
 * @return [1]; 0 for models that do as well.
 */
double modelDistance(const Modelled& one, const Modelled& other);

/**
 * @brief The largest that two sound recordings of one battery have [1].
 *
 *     max(0.7, sqrt(6000 s / T)),   T: the shorter duration
 *
 * What a recording is in (temperature, charge) averages over its duration
 * (docs/decisions/0021-changes-against-a-reference.md).
 *
 * @param has_clear_change a change of the instruments is clear, which moves the models as well where
 * it is put in with a strength that is not quite its own: 1 in place of 0.7.
 */
double largestDistance(const Series& one, const Series& other, bool has_clear_change);

}  // namespace battery_sof
