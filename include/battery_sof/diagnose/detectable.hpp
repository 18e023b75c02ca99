#pragma once

#include <vector>

#include "battery_sof/diagnose/diagnosis.hpp"
#include "battery_sof/diagnose/hypotheses.hpp"
#include "battery_sof/diagnose/thresholds.hpp"

namespace battery_sof {

/**
 * @brief Smallest strengths at which effects would have been named beside a model (PHYSICS 1.5).
 *
 * A name needs evidence and a fall of the error, so
 *
 *     strength = magnitude max( max(z_name, z_beside) / |S|, sqrt(1 / (1 - share)^2 - 1) rms(e) / rms(s_free) )
 *
 * |S|: z at the magnitude (Signature::sensitivity). s_free: what the effect at its magnitude adds to the voltage [V] less
 * what the parameters take up. Both RMS over the samples on which it acts most, as gainOf() has them; share: the thresholds'
 * for its tier. z_beside: score of the strongest other hypothesis, which would be taken first. e: what the model leaves on
 * blocks held out of its fit (heldOutErrors()); an effect adds to an error that knows nothing of it.
 *
 * @param fit what the effects were screened beside, on this drive. @param threads 0: as many as the machine has.
 * @return one an effect that has a typical strength, in the order given.
 */
std::vector<Detectable> detectableBeside(const WhitenedFit& fit, const Drive& drive, const std::vector<Signature>& screened,
                                         const DiagnosisThresholds& thresholds, int threads);

}  // namespace battery_sof
