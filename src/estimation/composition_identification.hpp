#pragma once

#include "estimation/composition_fit.hpp"
#include "estimation/identification.hpp"

namespace battery_sof {

/**
 * @brief identify() for options with effects or whitening; same arguments, checked by identify().
 *
 * Starts: the base model's optimum with the new strengths at zero, the same with them at their
 * magnitudes, and options.more_starts. With options.whiten noise and fit are estimated in turns,
 * twice each.
 *
 * @param base the base model's optimum under eq. 3.
 */
FittedModel identifyComposition(const Series& series, IndexRange range,
                                const IdentifyOptions& options, const CompositionPoint& base);

/**
 * @brief The model of an optimum that was found elsewhere under a noise model: scores, standard
 * errors, state at the end.
 * @param options effects and masked are used.  @param optimum in the composition of
 * options.effects.
 */
FittedModel completedModel(const Series& series, IndexRange range, const IdentifyOptions& options,
                           const CompositionPoint& optimum, const NoiseModel& noise);

}  // namespace battery_sof
