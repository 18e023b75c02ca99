#include "regression/discrepancy_curve.hpp"

#include <algorithm>

namespace battery_sof {
namespace {

constexpr double kLate = 60.0;  // [s], of a held current: beyond a stop's transients

}  // namespace

std::vector<DiscrepancyAtCurrent> curveOf(const DiscrepancyModel& discrepancy, double least,
                                          double most) {
  std::vector<DiscrepancyAtCurrent> curve;
  for (const double decade : {1.0, 10.0, 100.0})
    for (const double size : {decade, 2.0 * decade, 5.0 * decade}) {
      if (size > std::max(most, -least)) continue;
      const std::vector<DiscrepancyAnswer> answers = answersOf(discrepancy, size, kLate);
      if (answers.empty()) continue;
      const DiscrepancyAnswer &early = answers.front(), &late = answers.back();
      if (size <= most)
        curve.push_back(
            {size, early.charging, late.charging, early.charging_std, late.charging_std});
      if (size <= -least)
        curve.push_back({-size, early.discharging, late.discharging, early.discharging_std,
                         late.discharging_std});
    }
  std::sort(curve.begin(), curve.end(),
            [](const DiscrepancyAtCurrent& a, const DiscrepancyAtCurrent& b) {
              return a.current < b.current;
            });
  return curve;
}

}  // namespace battery_sof
