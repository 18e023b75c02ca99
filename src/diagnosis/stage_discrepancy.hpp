#pragma once

#include <algorithm>
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
  /// worth a place in the model alone. A block that the others hardly determine is missed by more
  /// than what is missing: the circuit fitted to all of them must be missed by more, too.
  bool holds() const {
    if (!isUsed()) return false;
    const LeftOutErrors& errors = finding->left_out;
    return errors.discrepancy <
           std::min((1.0 - kCatalogueTolerance) * errors.base, errors.in_sample);
  }
};

EstimatedDiscrepancy estimateDiscrepancy(const Prepared& prepared, const Explained& explained,
                                         const FinalFit& last, const DiagnoseOptions& options);

}  // namespace battery_sof
