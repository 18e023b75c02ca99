#include "battery_sof/predict/range_prediction.hpp"

#include <utility>

#include "battery_sof/predict/row_of_blocks.hpp"
#include "battery_sof/recording/blocks.hpp"

namespace battery_sof {
namespace {

/// The current drives throughout: what drives is as measured.
FollowedPrediction currentDriven(const FittedModel& model, const Series& series, IndexRange range) {
  const PredictedVoltage voltage = predictSeries(model, series, range);
  FollowedPrediction predicted;
  predicted.voltage_drives.assign(range.size(), 0);
  predicted.voltage = predicted.equations_voltage = voltage.voltage;
  predicted.voltage_lower = voltage.lower;
  predicted.voltage_upper = voltage.upper;
  const Series part = slice(series, range);
  predicted.current = predicted.current_lower = predicted.current_upper = part.current;
  return predicted;
}

/// Whether the voltage drives where a source imposes it; gives the fit a source when it was fitted without.
bool drivesBothWays(Fit& fit, const Series& series, DriveMode drive) {
  if (drive == DriveMode::kCurrent) return false;
  if (drive == DriveMode::kAsFitted || fit.source) return fit.source.has_value();
  const Source source = findSource(series);
  if (!source.seen) throw NoSource("no source is seen in the recording: " + source.summary);
  fit.source = source.rule;
  return true;
}

PredictionReport scored(const Fit& fit, const Series& series, IndexRange range, const FollowedPrediction& from_current,
                        const FollowedPrediction& predicted) {
  PredictionReport report;
  report.from_current = scorePrediction(series, range, {from_current.voltage, from_current.voltage_lower, from_current.voltage_upper});
  report.naive = scoreNaive(fit.naive, series, range, predicted.voltage_drives);
  const PredictedVoltage line = naiveVoltage(fit.naive, series, range);
  if (!line.voltage.empty()) report.naive_from_current = scorePrediction(series, range, line);
  return report;
}

}  // namespace

RangePrediction predictRange(FittedModel model, const Series& series, IndexRange range, DriveMode drive) {
  if (const double blocks = std::exchange(model.fit.blocks, 1.0); blocks != 1.0)
    return inRow(predictRange(std::move(model), ofOneBlock(series, blocks), range, drive), blocks);
  const bool both_ways = drivesBothWays(model.fit, series, drive);
  const FollowedPrediction from_current = currentDriven(model, series, range);
  RangePrediction result;
  result.course = both_ways ? predictMixed(model, series, range) : from_current;
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
