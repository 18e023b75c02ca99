#pragma once

#include <functional>
#include <optional>
#include <string>

#include "battery_sof/series.hpp"
#include "diagnosis/diagnosis.hpp"
#include "estimation/parameter_space.hpp"

namespace battery_sof {

struct DiagnoseOptions {
  /// for fits side by side; 0: as many as the machine has; the result is the same
  int threads = 1;
  /// of the samples, the last ones: opened once, at the end
  double holdout_share = 0.25;
  Relevance relevance;                       ///< what is smaller is not reported
  std::vector<std::string> hypotheses = {};  ///< ids to weigh; empty for all
  /// Ids that are known to be there: the extended model is the base model with these, and nothing
  /// is searched for.
  std::vector<std::string> given = {};
  /// What is known of parameters, in place of the catalogue's priors: for the base circuit and
  /// for every set of effects of which it has a population.
  std::vector<KnownPopulation> priors = {};
  bool anyway = false;  ///< a recording with a problem (findProblems()) is diagnosed all the same
  /// [A], below 0, what counts as an engine start; none: as the recording shows it
  /// (findCrankCurrent()). diagnose() sets it.
  std::optional<double> crank_current = std::nullopt;
  /// [Ah], nominal: who moves a tenth of it moves the open-circuit voltage. None: kTypicalCapacity.
  /// It is no part of the fits, where it gains nothing
  /// (docs/decisions/0020-effects-that-predict-left-out-blocks.md).
  std::optional<double> capacity = std::nullopt;
  bool lists_detection_limits = true;  ///< false: Diagnosis::detection_limits stays empty
  /// Gets what begins; called from the calling thread.
  std::function<void(const std::string& stage)> progress = nullptr;
  /// Called often while the search works, from the calling thread; what it or progress throws ends
  /// the diagnosis.
  std::function<void()> pulse = nullptr;
};

/**
 * @brief Locates where the base model and a recording deviate, names what is missing, models it and
 * shows what that gains.
 *
 * Instrument screen; base fit; regimes with errors and the parameters they bias; mechanisms by
 * evidence and the effects that represent them (explain()); a discrepancy model of the residual;
 * segments of mismatch; hold-out (docs/diagnosis.md).
 *
 * @param recording any sampling; its last holdout_share is used for the comparison alone.
 * @return a verdict, also for poor data: insufficient_data and the reason. Same input, same answer,
 * for any number of threads.
 * @throws std::invalid_argument for options outside their ranges and unknown ids.
 */
Diagnosis diagnose(const Recording& recording, const DiagnoseOptions& options = {});

/// @return what a recording's training part says for each mechanism: zeros for poor data.
MechanismEvidence mechanismEvidence(const Recording& recording);

}  // namespace battery_sof
