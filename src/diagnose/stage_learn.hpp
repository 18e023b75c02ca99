#pragma once

#include <optional>

#include "stage_fit.hpp"

namespace battery_sof {

/// What currents and their memory say of the voltage beside the model, by blocks that are left out.
struct Learned {
  LeftOver left;
  std::optional<LearnedFinding> finding;  ///< none where it is neither used nor needed
  std::optional<WhitenedFit> with_force;  ///< where it is used: the model with it
  bool isUsed() const { return finding && finding->is_used; }
  /// Whether it takes enough of the error on left-out blocks to be told of; a little less error is worth a place in the model alone.
  bool holds() const { return isUsed() && finding->left_out.force < (1.0 - kDiscrepancy) * finding->left_out.base; }
};

Learned learnRest(const Prepared& prepared, const Explained& explained, const FinalFit& last, const DiagnoseOptions& options);

}  // namespace battery_sof
