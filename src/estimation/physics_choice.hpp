#pragma once

#include "estimation/identification.hpp"

namespace battery_sof {

/**
 * @brief identify() with the physics that the window's charge calls for (movedCharge()).
 *
 * - Where a source controls the voltage: that of charging (fresh_sulphate), else the circuit.
 * - Where a tenth of the capacity was moved: that of the open-circuit voltage (ocv_soc), of its end
 *   if a tenth was drawn (end_of_discharge) and of a charge's if a tenth was charged by a source
 *   (acceptance_soc); the same with a resistance that follows the charge (resistance_soc) but under
 *   one load, which shows no resistance; and what was said first, unless the charge went one way or
 *   there and back once, since nothing is then charged while it is still fresh. A later
 *   one is taken where it predicts left-out blocks better by more than a standard error
 *   (scoreBlocks()).
 *
 * A composition is fitted effect by effect: each larger one begins at the smaller one's optimum, too.
 * Where it is not usable as a whole, the largest one at its beginning that is stands for it; where
 * none is usable, the circuit.
 *
 * @param options without effects.
 * @return the model; its status says whether it is usable.
 */
FittedModel identifyWithChosenPhysics(const Series& series, IndexRange range,
                                      const IdentifyOptions& options);

}  // namespace battery_sof
