#pragma once

#include <functional>
#include <optional>
#include <string>

#include "battery_sof/series.hpp"
#include "diagnosis/diagnosis.hpp"
#include "prediction/identification_job.hpp"

namespace battery_sof {

// What the node's workers do, with the clock that the core does not have. Nothing is thrown.

/// runIdentification() with fit_ms filled in; an exception becomes a result without a model.
IdentificationResult timedIdentification(const IdentificationJob& job);

/// What a diagnosis came to.
struct DiagnosisReport {
  std::optional<Diagnosis> diagnosis;  ///< none when it broke off
  std::string fault;                   ///< why, one sentence
  double from = 0.0, to = 0.0;         ///< [s], of the recording
  std::size_t samples = 0;
  double duration_ms = 0.0;  ///< [ms], wall time
};

/// diagnose() on one thread. @param priors see DiagnoseOptions. @param why_end asked often: what is
/// not empty breaks it off. @param begins reported of each stage.
DiagnosisReport timedDiagnosis(const Recording& recording,
                               const std::vector<KnownPopulation>& priors,
                               const std::function<std::string()>& why_end,
                               const std::function<void(const std::string& stage)>& begins);

}  // namespace battery_sof
