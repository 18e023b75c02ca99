#pragma once

#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

/**
 * @brief What the current channel shows around a smooth course, and how much of it the battery saw.
 *
 *     i = smooth + flicker,   share = cov(u's own flicker, flicker) / (r var(flicker))
 *
 * r is from the steps of the current. smooth is a local quadratic over the least noisy of several
 * windows, up to half a second to either side or to one, in which the current departs from it by no
 * more than its own noise; at edges there is none and smooth is the sample itself. A
 * sensor's noise has share 0: the battery's voltage knows nothing of it, yet a model driven by the
 * measured current would show r times it, and whatever filters the current would seem to fit better
 * (errors in variables). A load's ripple has share 1.
 */
struct CurrentFlicker {
  std::vector<double> smooth;  ///< [A], one a sample
  double share = 1.0;          ///< [0, 1]; 1 where it cannot be estimated
};

/// @return the flicker of a series; smooth equal to the current and share 1 for fewer than ten
/// samples a second.
CurrentFlicker currentFlicker(const Series& series);

/// @return the series with the share of the flicker that the battery did not see taken out of the
/// current.
Series withoutSensorNoise(const Series& series, const CurrentFlicker& flicker);

}  // namespace battery_sof
