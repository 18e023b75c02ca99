#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnosis.hpp"

namespace battery_sof {

/// What several recordings of one battery say together.
struct CombinedDiagnosis {
  /// likeliest; none where no recording has one, or all that have one have none in common
  std::optional<Mechanism> mechanism;
  std::vector<MechanismProbability> mechanisms;  ///< as Diagnosis::mechanisms; empty without one
  std::string summary;                           ///< one plain sentence
};

/**
 * @brief Classifies the mean evidence of the recordings that have a mechanism.
 *
 * The mean, not the sum: given the truth, recordings of one battery share the model's error
 * (docs/diagnosis.md#several-recordings). What was accepted counts by the share of recordings that
 * did.
 *
 * @param recordings of one battery, each another drive.
 */
CombinedDiagnosis combine(const std::vector<Diagnosis>& recordings);

}  // namespace battery_sof
