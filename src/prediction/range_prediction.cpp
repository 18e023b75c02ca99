#include "prediction/range_prediction.hpp"

#include <utility>

#include "prediction/series_blocks.hpp"
#include "recording/series_blocks.hpp"

namespace battery_sof {
namespace {

/// Whether the voltage is the input where a source controls it; gives the fit a source when it was
/// fitted without.
bool drivesBothWays(Fit& fit, const Series& series, PredictionMode mode) {
  if (mode == PredictionMode::kCurrent) return false;
  if (mode == PredictionMode::kAsFitted || fit.source) return fit.source.has_value();
  const ControlModes source = detectControlMode(series);
  if (!source.seen) throw NoSource("no source is seen in the recording: " + source.summary);
  fit.source = source.rule;
  return true;
}

PredictionReport scored(const Fit& fit, const Series& series, IndexRange range,
                        const FollowedPrediction& from_current,
                        const FollowedPrediction& predicted) {
  PredictionReport report;
  report.from_current = scorePrediction(series, range, from_current.voltages());
  report.baseline = scoreBaseline(fit.baseline, series, range, predicted.voltage_controlled);
  const PredictedVoltage line = baselineVoltage(fit.baseline, series, range);
  if (!line.voltage.empty()) report.baseline_from_current = scorePrediction(series, range, line);
  return report;
}

}  // namespace

RangePrediction predictRange(FittedModel model, const Series& series, IndexRange range,
                             PredictionMode mode) {
  if (const double series_blocks = std::exchange(model.fit.series_blocks, 1.0);
      series_blocks != 1.0)
    return ofSeries(predictRange(std::move(model), perBlock(series, series_blocks), range, mode),
                    series_blocks);
  const bool both_ways = drivesBothWays(model.fit, series, mode);
  const FollowedPrediction from_current = predictSeries(drivenByCurrent(model), series, range);
  RangePrediction result;
  result.course = both_ways ? predictSeries(model, series, range) : from_current;
  PredictionReport& report = result.report;
  report = scored(model.fit, series, range, from_current, result.course);
  if (both_ways) {
    report.both_ways = scoreBothWays(model, series, range, result.course);
    report.from_current.cranks = report.both_ways->cranks;
    report.from_current.crank_mean_abs_error = report.both_ways->crank_mean_abs_error;
  }
  return result;
}

}  // namespace battery_sof
