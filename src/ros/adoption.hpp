#pragma once

#include <memory>
#include <string>
#include <vector>

#include "diagnosis/diagnosis.hpp"

namespace battery_sof {

/// What a session is to try of a diagnosis, and why.
struct Adoption {
  std::vector<std::string> effects;  ///< the extended composition; empty: nothing
  std::string sentence;
  /// of "discrepancy" among the effects
  std::shared_ptr<const DiscrepancyModel> discrepancy = nullptr;
};

/**
 * @brief Whether a diagnosis' extended composition is evaluated in parallel to the base model.
 *
 * It does when the verdict is named or several and the composition holds structure or physics
 * (tiers S and P), and whenever it holds a discrepancy. Instrument effects (tier I)
 * come along with those, and the sentence names them all; alone they do not: a faulty instrument
 * needs repair, and a question's currents are true ones, not what that instrument would have read.
 * @param allowed parameter use_diagnosis.
 */
Adoption adoptionOf(const Diagnosis& diagnosis, bool allowed);

}  // namespace battery_sof
