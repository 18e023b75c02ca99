#pragma once

#include <optional>
#include <vector>

#include "model/discrepancy_model.hpp"

namespace battery_sof {

/// What a discrepancy adds while a held current flows.
struct DiscrepancyAnswer {
  /// [s], since a rest
  double time = 0.0;
  double charging = 0.0;     ///< [V]
  double discharging = 0.0;  ///< [V]
  /// [V], by the discrepancy's covariance; none without it
  std::optional<double> charging_std = std::nullopt, discharging_std = std::nullopt;
};

/// @brief A discrepancy as an engineer reads it: what it adds under a held current from rest on,
/// less what it adds at rest.
/// @param current [A], > 0; charged and discharged with.  @param longest [s]; never more than a
/// third of what was estimated from, nor half a day.
std::vector<DiscrepancyAnswer> answersOf(const DiscrepancyModel& discrepancy, double current,
                                         double longest = 1e9);

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
