#pragma once

#include <array>
#include <optional>
#include <vector>

#include "model/mechanism.hpp"

namespace battery_sof {

/// What a recording says for one mechanism in addition to the base circuit [ln evidence].
struct MechanismSupport {
  double alone = 0.0;  ///< gain by its regressors alone
  double lost = 0.0;   ///< loss when they are taken out of the regressors of all mechanisms
  /// gain by the best of its effects, on a grid of shapes, linear in the strength
  double effect = 0.0;
};

/// The same of all mechanisms, of one recording or summed over several of one battery.
using MechanismEvidence = std::array<MechanismSupport, kMechanisms>;
MechanismEvidence& operator+=(MechanismEvidence& sum, const MechanismEvidence& other);

struct MechanismProbability {
  Mechanism mechanism = Mechanism::kStructure;
  double probability = 0.0;
};

/**
 * @brief Which mechanism is missing, given that one is.
 *
 *     p_m = exp(w_m x_m + b_m) / sum,   x_m: m's alone, lost and effect, each relative to the largest
 *
 * The weights were fitted to simulated batteries whose laws are
 * in no catalogue, under drives that do not depend on the law (mechanism_weights.inc, docs/
 * validation.md); probabilities are calibrated on laws that were left out.
 *
 * @return all mechanisms, likeliest first.
 */
std::vector<MechanismProbability> mechanismProbabilities(const MechanismEvidence& evidence);

/// @return the fewest of them whose probabilities add up to 0.9.
/// @param holds mechanism of which an effect holds: it comes first.
std::vector<MechanismProbability> likelyMechanisms(const MechanismEvidence& evidence,
                                                   std::optional<Mechanism> holds = std::nullopt);

}  // namespace battery_sof
