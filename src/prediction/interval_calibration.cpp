#include "prediction/interval_calibration.hpp"

#include <algorithm>
#include <cmath>

namespace battery_sof {
namespace {

constexpr double kRate = 0.25;      // eta: an outlier widens by a quarter
constexpr double kMissShare = 0.1;  // of a 90 % interval
constexpr double kLeast = 0.1, kMost = 50.0;

}  // namespace

void update(IntervalCalibration& scale, double measured, const Interval& expected) {
  const bool inside = measured >= expected.lower && measured <= expected.upper;
  ++scale.events;
  if (inside) ++scale.inside;
  const double step = inside ? -kMissShare : 1.0 - kMissShare;
  scale.factor = std::clamp(scale.factor * std::exp(kRate * step), kLeast, kMost);
}

}  // namespace battery_sof
