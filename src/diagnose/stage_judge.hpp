#pragma once

#include <optional>
#include <vector>

#include "stage_learn.hpp"

namespace battery_sof {

/// What the findings come to.
struct Judged {
  Verdict verdict = Verdict::kInsufficientData;
  std::vector<Component> components;  ///< of the explanation; their probability as it is told
  std::optional<Family> family;
  double probability = 0.0;           ///< of it [0, 1]
  std::vector<Candidate> candidates;  ///< best first
  std::vector<Detectable> detectable;
};

Judged judgeFindings(const Recording& recording, const Prepared& prepared, const Explained& explained, const FinalFit& last,
                     const Learned& learned, const DiagnoseOptions& options);

}  // namespace battery_sof
