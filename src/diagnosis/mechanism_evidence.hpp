#pragma once

#include <array>
#include <vector>

#include "model/mechanism.hpp"

namespace battery_sof {

/// What a recording says for one mechanism in addition to the base circuit [ln evidence].
struct MechanismSupport {
  double alone = 0.0;  ///< gain by its regressors alone
  double lost = 0.0;   ///< loss when they are taken out of the regressors of all mechanisms
  /// gain by the best of its effects, on a grid of shapes, linear in the strength
  double effect = 0.0;
  /// What the model selection accepted of it, by effects and by its regressors: square root of its
  /// gain of ln evidence as a share of the largest [0, 1]; of several recordings their mean.
  double accepted = 0.0;
};

/// The same of all mechanisms, as some rows of a recording say it.
using MechanismEvidence = std::array<MechanismSupport, kMechanisms>;

struct MechanismProbability {
  Mechanism mechanism = Mechanism::kStructure;
  double probability = 0.0;
};

/**
 * @brief Which mechanism is missing, given that one is.
 *
 *     p_m = mean over samples of exp(w_m x_m + b_m + 3 accepted_m) / sum  [1]
 *
 * x_m has two numbers of each of m's alone, lost and effect, e: -ln(1 + e_max - e) and
 * e / max(e_max, 1), where e_max is the largest of all mechanisms. The weights were fitted to
 * simulated batteries whose laws are in no catalogue, under drives that do not depend on the law
 * (mechanism_weights.inc, docs/validation.md). What the model selection accepted counts in addition:
 * linear fits do not change with the way of a search, and see less than it.
 *
 * The mean over halves of the rows, every two quarters, is a bagged posterior (Huggins and Miller 2023):
 * where no model is right, evidence grows with the rows for whichever fits them best, and halves of
 * one recording name different mechanisms with certainty; their mean says how far they agree.
 *
 * @param samples what each half-sample says; one, of all rows, is no mean.
 * @param is_lead_acid otherwise mechanisms of lead and acid are no candidates.
 * @return all candidates, likeliest first.
 */
std::vector<MechanismProbability> mechanismProbabilities(
    const std::vector<MechanismEvidence>& samples, bool is_lead_acid = true);

/// @return the fewest of them whose probabilities add up to 0.9.
std::vector<MechanismProbability> likelyMechanisms(const std::vector<MechanismEvidence>& samples,
                                                   bool is_lead_acid = true);

}  // namespace battery_sof
