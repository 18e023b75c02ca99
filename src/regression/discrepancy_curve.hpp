#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "battery_sof/series.hpp"
#include "model/discrepancy_model.hpp"

namespace battery_sof {

/// How long at a stretch a current was driven [s]; 0 for one that never was. Negative currents are
/// discharges.
using DrivenTime = std::function<double(double current)>;

/// @return of a range of a series: the longest stretch without a gap in which the current had its
/// sign and at least half its size; 0 where it never had all of it. The series must outlive it.
DrivenTime drivenTimeOf(const Series& series, IndexRange range);

/// @return the size of a current that answers are given for [A]: of 1, 2 and 5 times powers of ten
/// the largest up to 20 A that was driven, in both directions unless one of them never had a
/// twentieth of the other's size; none where nothing was driven.
std::optional<double> answerCurrentOf(const DrivenTime& driven);

/// What a discrepancy adds while a held current flows.
struct DiscrepancyAnswer {
  /// [s], since a rest
  double time = 0.0;
  double charging = 0.0;     ///< [V]; NaN where such a current was not driven for so long
  double discharging = 0.0;  ///< [V], likewise
  /// [V], by the discrepancy's covariance; none without it
  std::optional<double> charging_std = std::nullopt, discharging_std = std::nullopt;
};

/// @brief A discrepancy as an engineer reads it: what it adds under a held current from rest on,
/// less what it adds at rest.
/// @param current [A], > 0; charged and discharged with.
/// @return until neither direction was driven for so long; never beyond half a day.
std::vector<DiscrepancyAnswer> answersOf(const DiscrepancyModel& discrepancy, double current,
                                         const DrivenTime& driven);

/// What a discrepancy model adds under a held current from rest on, less what it adds at rest.
struct DiscrepancyAtCurrent {
  /// [A], positive into the battery
  double current = 0.0;
  /// [V], after a tenth of a second, or a sampling interval
  double early = 0.0;
  /// [V], after about a minute; NaN where it was not driven for so long
  double late = 0.0;
  /// [V], as of DiscrepancyAnswer
  std::optional<double> early_std = std::nullopt, late_std = std::nullopt;
};

/**
 * @brief A discrepancy model over the current: answersOf() at 1, 2 and 5 times powers of ten, in
 * each direction as far as it was driven, down to a hundredth of the largest.
 * @return ascending in the current; empty where the discrepancy was estimated from too short a
 * time to answer.
 */
std::vector<DiscrepancyAtCurrent> curveOf(const DiscrepancyModel& discrepancy,
                                          const DrivenTime& driven);

}  // namespace battery_sof
