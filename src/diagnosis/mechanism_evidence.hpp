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

/// The same of all mechanisms.
using MechanismEvidence = std::array<MechanismSupport, kMechanisms>;

struct MechanismProbability {
  Mechanism mechanism = Mechanism::kStructure;
  double probability = 0.0;
};

/**
 * @brief Which mechanism is missing, given that one is.
 *
 *     p_m = exp(w_m x_m + b_m) / sum  [1]
 *
 * x_m are m's alone, lost and effect, each relative to the largest. The weights were fitted to
 * simulated batteries whose laws are in no catalogue, under drives that do not depend on the law
 * (mechanism_weights.inc, docs/validation.md); probabilities are calibrated on laws left out.
 *
 * @return all mechanisms, likeliest first.
 */
std::vector<MechanismProbability> mechanismProbabilities(const MechanismEvidence& evidence);

/// @return the fewest of them whose probabilities add up to 0.9, and holds.
/// @param holds mechanism whose regressors hold.
std::vector<MechanismProbability> likelyMechanisms(const MechanismEvidence& evidence,
                                                   std::optional<Mechanism> holds = std::nullopt);

/**
 * @brief The same where effects were accepted: probabilities of the mechanism that moves the
 * voltage most. The accepted ones come first, each with its share of what those before it leave,
 * then the others by their evidence, until 0.9. None is above the one before it.
 *
 * @param accepted of the effects, in their order; a mechanism counts once.
 */
std::vector<MechanismProbability> acceptedFirst(const std::vector<MechanismProbability>& accepted,
                                                const MechanismEvidence& evidence);

}  // namespace battery_sof
