#include "prediction/series_blocks.hpp"

#include <initializer_list>

namespace battery_sof {
namespace {

void scale(double& voltage, double series_blocks) { voltage *= series_blocks; }

void scale(std::optional<double>& voltage, double series_blocks) {
  if (voltage) *voltage *= series_blocks;
}

void scale(Interval& voltage, double series_blocks) { voltage = ofSeries(voltage, series_blocks); }

void scale(std::vector<double>& voltages, double series_blocks) {
  for (double& voltage : voltages) voltage *= series_blocks;
}

void scale(std::vector<CrankScore>& cranks, double series_blocks) {
  for (CrankScore& crank : cranks) {
    scale(crank.measured_minimum, series_blocks);
    scale(crank.predicted_minimum, series_blocks);
  }
}

void scale(PredictionScores& scores, double series_blocks) {
  scale(scores.rmse, series_blocks);
  scale(scores.max_abs, series_blocks);
  scale(scores.cranks, series_blocks);
  scale(scores.crank_mean_abs_error, series_blocks);
}

void scale(BothWaysScores& scores, double series_blocks) {
  for (ChargeScore& charge : scores.mixed.charges) {
    scale(charge.mean_voltage, series_blocks);
    scale(charge.first_voltage, series_blocks);
  }
  scale(scores.cranks, series_blocks);
  scale(scores.crank_mean_abs_error, series_blocks);
}

}  // namespace

RangePrediction ofSeries(RangePrediction of_one, double series_blocks) {
  FollowedPrediction& course = of_one.course;
  for (std::vector<double>* voltages :
       {&course.voltage, &course.voltage_lower, &course.voltage_upper, &course.equations_voltage})
    scale(*voltages, series_blocks);
  PredictionReport& report = of_one.report;
  scale(report.from_current, series_blocks);
  scale(report.baseline, series_blocks);
  if (report.both_ways) scale(*report.both_ways, series_blocks);
  if (report.baseline_from_current) scale(*report.baseline_from_current, series_blocks);
  return of_one;
}

SessionEvents ofSeries(SessionEvents of_one, double series_blocks) {
  for (auto* events : {&of_one.cranks, &of_one.stops})
    for (EventComparison& event : *events) {
      scale(event.measured, series_blocks);
      scale(event.expected, series_blocks);
      scale(event.modelled, series_blocks);
      if (event.baseline) scale(*event.baseline, series_blocks);
    }
  for (EventComparison& charge : of_one.charges) {
    scale(charge.voltage, series_blocks);
    scale(charge.first_voltage, series_blocks);
  }
  return of_one;
}

SessionStatus ofSeries(SessionStatus of_one, double series_blocks) {
  if (of_one.expected) scale(of_one.expected->voltage, series_blocks);
  if (of_one.selector)
    for (double* voltage :
         {&of_one.selector->base_rmse, &of_one.selector->extended_rmse,
          &of_one.selector->base_crank_error, &of_one.selector->extended_crank_error})
      scale(*voltage, series_blocks);
  return of_one;
}

}  // namespace battery_sof
