#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "diagnosis/diagnosis.hpp"
#include "prediction/identification_job.hpp"

namespace battery_sof {

// What the node's workers do, with the clock that the core does not have. Nothing is thrown.

/// runIdentification() with fit_ms filled in; an exception becomes a result without a model.
IdentificationResult timedIdentification(const IdentificationJob& job);

/// What a diagnosis came to.
struct FinishedDiagnosis {
  std::optional<Diagnosis> diagnosis;  ///< none when it broke off
  std::string fault;                   ///< why, one sentence
  double from = 0.0, to = 0.0;         ///< [s], of the recording
  std::size_t samples = 0;
  double duration_ms = 0.0;  ///< [ms], wall time
};

/// diagnose() on one thread. @param priors see DiagnoseOptions. @param why_end asked often: what is
/// not empty breaks it off. @param begins reported of each stage.
FinishedDiagnosis timedDiagnosis(const Recording& recording,
                                 const std::vector<KnownPopulation>& priors,
                                 const std::function<std::string()>& why_end,
                                 const std::function<void(const std::string& stage)>& begins);

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
