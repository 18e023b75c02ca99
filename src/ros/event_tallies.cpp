#include "ros/event_tallies.hpp"

#include <cmath>

namespace battery_sof {

void EventTally::add(double measured, const Interval& expected) {
  ++count;
  sum_abs_error += std::abs(measured - expected.value);
  if (expected.lower <= measured && measured <= expected.upper) ++inside;
}

std::optional<double> EventTally::coverageOf() const {
  if (count == 0) return std::nullopt;
  return static_cast<double>(inside) / static_cast<double>(count);
}

std::optional<double> EventTally::meanAbsError() const {
  if (count == 0) return std::nullopt;
  return sum_abs_error / static_cast<double>(count);
}

void EventTallies::add(const SessionEvents& events) {
  for (const CrankComparison& crank : events.cranks) {
    cranks.add(crank.measured_minimum, crank.expected_minimum);
    if (crank.baseline_minimum)
      baseline_cranks.add(crank.measured_minimum, *crank.baseline_minimum);
    answered_cranks.add(crank.measured_minimum,
                        crank.baseline_answered ? *crank.baseline_minimum : crank.expected_minimum);
    last_crank = crank;
  }
  for (const ChargeComparison& charge : events.charges) {
    charges.add(charge.measured_current, charge.expected_current);
    if (charge.baseline_current)
      baseline_charges.add(charge.measured_current, *charge.baseline_current);
    answered_charges.add(charge.measured_current, charge.baseline_answered
                                                      ? *charge.baseline_current
                                                      : charge.expected_current);
    last_charge = charge;
  }
}

}  // namespace battery_sof
