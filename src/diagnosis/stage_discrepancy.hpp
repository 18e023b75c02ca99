#pragma once

#include <optional>

#include "stage_fit.hpp"

namespace battery_sof {

/// The discrepancy of the voltage by currents and their memory, checked on blocks left out.
struct EstimatedDiscrepancy {
  UnexplainedPart unexplained;
  std::optional<DiscrepancyFinding> finding;    ///< none where it is neither used nor needed
  std::optional<WhitenedFit> with_discrepancy;  ///< where it is used: the model with it
  bool isUsed() const { return finding && finding->is_used; }
  /// Whether it takes enough of the error on left-out blocks to be reported; a little less error is
  /// worth a place in the model alone.
  bool holds() const {
    return isUsed() &&
           finding->left_out.discrepancy < (1.0 - kCatalogueTolerance) * finding->left_out.base;
  }
};

EstimatedDiscrepancy estimateDiscrepancy(const Prepared& prepared, const Explained& explained,
                                         const FinalFit& last, const DiagnoseOptions& options);

}  // namespace battery_sof
