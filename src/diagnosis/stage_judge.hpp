#pragma once

#include <optional>
#include <vector>

#include "stage_discrepancy.hpp"

namespace battery_sof {

/// What the findings come to.
struct Judged {
  Verdict verdict = Verdict::kInsufficientData;
  std::vector<SelectedTerm> terms;  ///< of the explanation
  std::optional<Mechanism> mechanism;
  double probability = 0.0;                      ///< of it [0, 1]
  std::vector<MechanismProbability> mechanisms;  ///< Diagnosis::mechanisms
  MechanismEvidence evidence{};                  ///< with what was accepted
  std::vector<Candidate> candidates;             ///< best first
  std::vector<DetectionLimit> detection_limits;
};

Judged judgeFindings(const Recording& recording, const Prepared& prepared,
                     const Explained& explained, const FinalFit& last,
                     const EstimatedDiscrepancy& discrepancy, const DiagnoseOptions& options);

}  // namespace battery_sof
