#pragma once

#include <vector>

#include "battery_sof/diagnose/whitened_fit.hpp"

namespace battery_sof {

/// A model's error on one block that its fit did not see.
struct BlockError {
  double deviance = 0.0;  ///< -2 ln predictive density of the block's samples, one step ahead under the fit's noise
  double square = 0.0;    ///< [V^2], sum of the squared errors
  double samples = 0.0;
};

/**
 * @brief Errors of a fit on consecutive blocks, each left out of a refit of all parameters.
 *
 * The battery's state is carried through the block by the measured current; the noise stays the fit's, so only what the
 * physics learnt elsewhere counts.
 */
std::vector<BlockError> heldOutErrors(const WhitenedFit& fit, const Drive& drive, int blocks, int threads);

}  // namespace battery_sof
