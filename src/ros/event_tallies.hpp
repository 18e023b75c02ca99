#pragma once

#include <cstddef>
#include <optional>

#include "prediction/online_session.hpp"

namespace battery_sof {

/// How events since the start compare with what the model expected.
struct EventTally {
  std::size_t count = 0;
  std::size_t inside = 0;      ///< inside their 90 % interval
  double sum_abs_error = 0.0;  ///< [V] or [A]

  void add(double measured, const Interval& expected);
  std::optional<double> coverageOf() const;    ///< none before the first
  std::optional<double> meanAbsError() const;  ///< the same
};

/// The cranks and charges of the running back-test.
struct EventTallies {
  EventTally cranks, charges;  ///< of the model
  /// of its window's baseline predictors, where they expected something
  EventTally baseline_cranks, baseline_charges;
  /// of the one that answered questions then (BaselineSelector)
  EventTally answered_cranks, answered_charges;
  std::optional<CrankComparison> last_crank;
  std::optional<ChargeComparison> last_charge;
  IntervalCalibration crank_calibration, charge_calibration;

  void add(const SessionEvents& events);
};

}  // namespace battery_sof
