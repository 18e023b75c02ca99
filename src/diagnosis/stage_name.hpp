#pragma once

#include <optional>
#include <vector>

#include "stage_judge.hpp"

namespace battery_sof {

/// The models that are handed on, and the effects that stand in the extended one.
struct Named {
  FittedModel base, extended;  ///< extended equals base when nothing was added
  /// the base model in the direction that is controlled, where a source controls the voltage
  std::optional<FittedModel> base_both_ways;
  std::vector<NamedEffect> effects;
};

Named nameEffects(const Recording& recording, const Prepared& prepared, const Explained& explained,
                  const FinalFit& last, const EstimatedDiscrepancy& discrepancy,
                  const Judged& judged);

}  // namespace battery_sof
