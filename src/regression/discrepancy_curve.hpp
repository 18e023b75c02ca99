#pragma once

#include <vector>

#include "regression/discrepancy_fit.hpp"

namespace battery_sof {

/// What a discrepancy model adds under a held current from rest on, less what it adds at rest.
struct DiscrepancyAtCurrent {
  /// [A], positive into the battery
  double current = 0.0;
  /// [V], after a tenth of a second, or a sampling interval
  double early = 0.0;
  /// [V], after about a minute, or as long as its memory reaches
  double late = 0.0;
  /// [V], as of DiscrepancyAnswer
  std::optional<double> early_std = std::nullopt, late_std = std::nullopt;
};

/**
 * @brief A discrepancy model over the current: answersOf() at 1, 2, 5, 10, ... 500 A in both
 * directions.
 * @param least, most currents that it was estimated from [A], least <= most; none beyond them is
 * needed.
 * @return ascending in the current; empty where the discrepancy was estimated from too short a
 * time to answer.
 */
std::vector<DiscrepancyAtCurrent> curveOf(const DiscrepancyModel& discrepancy, double least,
                                          double most);

}  // namespace battery_sof
