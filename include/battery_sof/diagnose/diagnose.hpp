#pragma once

#include <functional>
#include <string>

#include "battery_sof/diagnose/diagnosis.hpp"
#include "battery_sof/diagnose/thresholds.hpp"
#include "battery_sof/recording/series.hpp"

namespace battery_sof {

struct DiagnoseOptions {
  int threads = 1;              ///< 0: as many as the machine has; the result is the same
  double holdout_share = 0.25;  ///< of the samples, the last ones: opened once, at the end
  DiagnosisThresholds thresholds;
  std::vector<std::string> hypotheses = {};  ///< ids to weigh; empty for all that need no request
  /// Ids that are known to be there: the extended model is the base model with these, and nothing is searched for.
  std::vector<std::string> given = {};
  bool lists_detectable = true;  ///< false: Diagnosis::detectable stays empty
  /// Ids whose strength in Diagnosis::detectable is one at which the recording with the effect put in was diagnosed and the
  /// effect named; up to six diagnoses each.
  std::vector<std::string> confirm = {};
  /// Told what begins; called from the calling thread.
  std::function<void(const std::string& stage)> progress = nullptr;
};

/**
 * @brief Locates where the base model and a recording part, names what is missing, models it and shows what that gains.
 *
 * PHYSICS, section 2: instrument screen; base fit by generalised least squares under a fitted noise model; regimes and
 * segments of mismatch, absorption map; score of every hypothesis after projecting out what the model absorbs; joint refits
 * of the best and their look-alikes; acceptance by information criterion, held-out blocks and least effect size; backward
 * check; classes that cannot be told apart; hold-out.
 *
 * @param recording any sampling; its last holdout_share is used for the comparison alone.
 * @return a verdict, also for poor data: insufficient_data and the reason. Same input, same answer, for any number of threads.
 * @throws std::invalid_argument for options outside their ranges and unknown ids.
 */
Diagnosis diagnose(const Recording& recording, const DiagnoseOptions& options = {});

}  // namespace battery_sof
