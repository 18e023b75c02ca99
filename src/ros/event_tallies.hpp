#pragma once

#include <cmath>
#include <cstddef>
#include <optional>

#include "prediction/online_session.hpp"

namespace battery_sof {

/// How events since the start compare with what the model expected.
struct EventTally {
  std::size_t count = 0;
  std::size_t inside = 0;      ///< inside their 90 % interval
  double sum_abs_error = 0.0;  ///< [V] or [A]

  void add(double measured, const Interval& expected) {
    ++count;
    sum_abs_error += std::abs(measured - expected.value);
    if (expected.lower <= measured && measured <= expected.upper) ++inside;
  }
  /// None before the first.
  std::optional<double> coverageOf() const { return perEvent(static_cast<double>(inside)); }
  std::optional<double> meanAbsError() const { return perEvent(sum_abs_error); }

 private:
  std::optional<double> perEvent(double sum) const {
    return count == 0 ? std::nullopt : std::optional<double>(sum / static_cast<double>(count));
  }
};

/// The cranks and charges of the running back-test.
struct EventTallies {
  EventTally cranks, charges;  ///< of the model
  /// of its window's baseline predictors, where they expected something
  EventTally baseline_cranks, baseline_charges;
  std::optional<EventComparison> last_crank, last_charge;
  IntervalCalibration crank_calibration, charge_calibration;

  void add(const SessionEvents& events) {
    for (const EventComparison& crank : events.cranks)
      add(last_crank.emplace(crank), cranks, baseline_cranks);
    for (const EventComparison& charge : events.charges)
      add(last_charge.emplace(charge), charges, baseline_charges);
  }

 private:
  static void add(const EventComparison& event, EventTally& model, EventTally& baseline) {
    model.add(event.measured, event.expected);
    if (event.baseline) baseline.add(event.measured, *event.baseline);
  }
};

}  // namespace battery_sof
