#include "prediction/both_ways.hpp"

#include <algorithm>
#include <cmath>

#include "prediction/event_corrections.hpp"

namespace battery_sof {
namespace {

std::vector<char> overSeries(const Series& series, IndexRange range,
                             const std::vector<char>& flags) {
  std::vector<char> mask(series.size(), 0);
  std::copy(flags.begin(), flags.end(), mask.begin() + static_cast<std::ptrdiff_t>(range.first));
  return mask;
}

std::optional<double> meanAbsError(const std::vector<CrankScore>& cranks) {
  if (cranks.empty()) return std::nullopt;
  double sum = 0.0;
  for (const CrankScore& crank : cranks)
    sum += std::abs(crank.measured_minimum - crank.predicted_minimum.value);
  return sum / static_cast<double>(cranks.size());
}

}  // namespace

BothWaysScores scoreBothWays(const FittedModel& model, const Series& series, IndexRange range,
                             const FollowedPrediction& predicted) {
  BothWaysScores scores;
  scores.mixed =
      scoreMixed(series, range, overSeries(series, range, predicted.voltage_controlled), predicted);
  for (ChargeScore& charge : scores.mixed.charges)
    charge.predicted = correctChargePrediction(
        model, {charge.mean_voltage, charge.first_voltage, charge.duration}, charge.predicted);
  scores.cranks = scorePrediction(series, range,
                                  {predicted.equations_voltage, predicted.voltage_lower,
                                   predicted.voltage_upper})
                      .cranks;
  for (CrankScore& crank : scores.cranks)
    crank.predicted_minimum = correctCrankPrediction(model, crank.current, crank.predicted_minimum);
  scores.crank_mean_abs_error = meanAbsError(scores.cranks);
  return scores;
}

BothWaysScores scoreBaseline(const BaselinePredictor& baseline, const Series& series,
                             IndexRange range, const std::vector<char>& voltage_controlled) {
  BothWaysScores scores;
  const std::vector<char> mask = overSeries(series, range, voltage_controlled);
  const MixedPrediction line = predictBaseline(baseline, series, range, mask);
  scores.mixed = scoreMixed(series, range, mask, line);
  for (ChargeScore& charge : scores.mixed.charges)
    if (const auto current = baselineChargeCurrent(baseline, charge.mean_voltage, charge.duration))
      charge.predicted = *current;
  if (line.voltage.empty()) return scores;
  scores.cranks = scorePrediction(series, range, line.voltages()).cranks;
  for (CrankScore& crank : scores.cranks)
    if (const auto minimum = baselineCrankMinimum(baseline, crank.current))
      crank.predicted_minimum = *minimum;
  scores.crank_mean_abs_error = meanAbsError(scores.cranks);
  return scores;
}

PredictedVoltage baselineVoltage(const BaselinePredictor& baseline, const Series& series,
                                 IndexRange range) {
  return predictBaseline(baseline, series, range, std::vector<char>(series.size(), 0)).voltages();
}

}  // namespace battery_sof
