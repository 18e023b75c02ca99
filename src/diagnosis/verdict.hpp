#pragma once

#include <string>
#include <vector>

#include "diagnosis/diagnosis.hpp"
#include "diagnosis/explanation.hpp"

namespace battery_sof {

/// What speaks for something that no component of an explanation represents.
struct Unexplained {
  bool is_tone = false;          ///< slowTone() in addition
  bool has_discrepancy = false;  ///< a discrepancy model predicts blocks that it was not fitted to
  double rmse = 0.0;             ///< [V], of the residual, white noise and rounding taken out
};

/**
 * @brief The verdict: the mechanisms that an explanation holds, and whether effects represent them.
 *
 * - instruments alone: sensor_fault; effects: effect or several, ambiguous where others would do as
 * well;
 * - the first component is a mechanism's regressors: unexplained (withMechanism());
 * - no component: unexplained where a tone stands out or more is left than instruments leave, else
 * sensor_fault for a fault of theirs, unexplained where a discrepancy is estimated, or no_mismatch.
 *
 * @param faults that the screen found, ids of tier I: clipping, dropouts, quantisation, aliasing,
 * time_skew.
 */
Verdict judge(const std::vector<SelectedTerm>& terms, const std::vector<std::string>& faults,
              const Unexplained& rest);

/// Removes what gains less than a tenth of the largest term, of another mechanism: a battery's own
/// law leaves as much of the catalogue's (kCatalogueTolerance), and a neutral change brings one or
/// another.
/// @param terms largest gain first.
void removeSmall(std::vector<SelectedTerm>& terms);

/// A verdict once the likeliest mechanism is known: what is unexplained has one; an equation that
/// fits, of a mechanism that another is likelier than, is ambiguous.
/// @param terms in their order; regressors alone are no equation.
Verdict withMechanism(Verdict verdict, const std::vector<SelectedTerm>& terms, Mechanism likeliest);

/// @return what no current and voltage can show (docs/physics.md#what-the-base-circuit-absorbs).
std::vector<std::string> outsideWhatSignalsShow();

/// @param skew [s], by which the checks found the voltage to come later: to be undone first.
/// @return what to do or record next, in one or two sentences.
std::string nextExperiment(const Diagnosis& diagnosis, std::optional<double> skew = std::nullopt);

/// @return one sentence that a workshop reads once: what is missing, how sure, what it costs, what
/// the extended model gains.
std::string summaryOf(const Diagnosis& diagnosis);

}  // namespace battery_sof
