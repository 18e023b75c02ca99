#pragma once

#include <functional>
#include <string>
#include <vector>

#include "battery_sof/diagnose/naming.hpp"

namespace battery_sof {

/// What a name takes beside a model.
struct NameRule {
  DiagnosisThresholds thresholds;
  std::vector<Accepted> accepted;  ///< what the model holds already
  double least_gain = 0.0;         ///< of -2 ln likelihood, below which something unknown stays the verdict (leastGainToExplain())
  WhitenedSearch search;
  std::vector<std::string> confirm = {};  ///< ids that is_named(), there where any is given, is asked of
  /// Whether a diagnosis names the effect once the voltage holds what it adds to the fit at this point.
  std::function<bool(const BatteryModel& larger, const CompositionPoint& point, const std::string& id)> is_named = nullptr;
};

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
 * That is linear, and a model may bend further than its derivatives say. So the effect is put in: what it would add at that
 * strength is added to the measured voltage, the model fitted to that without it, noise included. With it the fit would be
 * what it was; evidence D' - D - c_n k and rms(e' - e) / rms(e) must be what a name takes. Where they are not the strength
 * is raised by what they lack, at least twofold, as far as the catalogue's range goes. Another effect of the model or of
 * the catalogue may still take it up; rule.is_named asks for that.
 *
 * @param fit what the effects were screened beside, on this drive. @param threads 0: as many as the machine has.
 * @return one an effect that has a typical strength, in the order given.
 */
std::vector<Detectable> detectableBeside(const WhitenedFit& fit, const Drive& drive, const std::vector<Signature>& screened,
                                         const NameRule& rule, int threads);

}  // namespace battery_sof
