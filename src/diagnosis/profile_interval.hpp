#pragma once

#include <optional>
#include <string>

#include "diagnosis/whitened_fit.hpp"

namespace battery_sof {

/// A parameter's 95 % interval; a side is none where the likelihood does not fall by enough before
/// the bound.
struct ProfileInterval {
  std::optional<double> lower, upper;
};

/**
 * @brief Interval of one parameter by its profile likelihood (docs/physics.md#profile-likelihood).
 *
 *     { p : min over all others of D(p) - D(optimum) < 3.84 },   D: -2 ln likelihood with priors, the noise held
 *
 * Each end is looked for by a secant on the square root of the rise, every point refitted from its
 * neighbour.
 *
 * @param parameter name in the fit's composition, free in it.  @param first_step distance of the
 * first look, > 0.
 * @throws std::invalid_argument for an unknown parameter.
 */
ProfileInterval profileInterval(const WhitenedFit& fit, const InputSequence& inputs,
                                const std::string& parameter, double first_step);

}  // namespace battery_sof
