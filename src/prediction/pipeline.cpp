#include "prediction/pipeline.hpp"

#include <algorithm>
#include <cmath>

namespace battery_sof {
namespace {

constexpr double kRate = 0.25;      // eta: an outlier widens by a quarter
constexpr double kMissShare = 0.1;  // of a 90 % interval
constexpr double kLeast = 0.1, kMost = 50.0;

}  // namespace

Interval voltageAnswer(const Simulation& simulation, const ErrorForecast& error, double own,
                       const IntervalCalibration& scale) {
  const double variance = simulation.voltageDerivatives().squaredNorm() + error.variance +
                          own * own + std::pow(simulation.beyondIdentified(), 2);
  return ninetyPercent(simulation.voltage() + error.mean, std::sqrt(variance), scale.factor);
}

Interval crankAnswer(const FittedModel& model, double current, const Interval& lowest,
                     const ErrorForecast& fall) {
  const Interval u = correctCrankPrediction(model, current, lowest);
  const double more = kNinetyPercent * std::sqrt(fall.variance), value = u.value + fall.mean;
  return ofSeries({value, value - std::hypot(u.value - u.lower, more),
                   value + std::hypot(u.upper - u.value, more)},
                  model.fit.series_blocks);
}

Interval chargeAnswer(const FittedModel& model, const ChargeBeginning& charge,
                      const Interval& modelled, double i_limit) {
  Interval i = modelled;
  if (modelled.value < i_limit) i = correctChargePrediction(model, charge, modelled);
  if (!areNumbers(i)) return i;
  for (double* current : {&i.value, &i.lower, &i.upper}) *current = std::min(*current, i_limit);
  return i;
}

void update(IntervalCalibration& scale, double measured, const Interval& expected) {
  const bool inside = measured >= expected.lower && measured <= expected.upper;
  ++scale.events;
  if (inside) ++scale.inside;
  const double step = inside ? -kMissShare : 1.0 - kMissShare;
  scale.factor = std::clamp(scale.factor * std::exp(kRate * step), kLeast, kMost);
}

}  // namespace battery_sof
