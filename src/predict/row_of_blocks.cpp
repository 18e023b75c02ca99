#include "battery_sof/predict/row_of_blocks.hpp"

#include <initializer_list>

namespace battery_sof {
namespace {

void scale(double& voltage, double blocks) { voltage *= blocks; }

void scale(std::optional<double>& voltage, double blocks) {
  if (voltage) *voltage *= blocks;
}

void scale(Interval& voltage, double blocks) { voltage = inRow(voltage, blocks); }

void scale(std::vector<double>& voltages, double blocks) {
  for (double& voltage : voltages) voltage *= blocks;
}

void scale(std::vector<CrankScore>& cranks, double blocks) {
  for (CrankScore& crank : cranks) {
    scale(crank.measured_minimum, blocks);
    scale(crank.predicted_minimum, blocks);
  }
}

void scale(PredictionScores& scores, double blocks) {
  scale(scores.rmse, blocks);
  scale(scores.max_abs, blocks);
  scale(scores.cranks, blocks);
  scale(scores.crank_mean_abs_error, blocks);
}

void scale(BothWaysScores& scores, double blocks) {
  for (ChargeScore& charge : scores.mixed.charges) {
    scale(charge.mean_voltage, blocks);
    scale(charge.first_voltage, blocks);
  }
  scale(scores.cranks, blocks);
  scale(scores.crank_mean_abs_error, blocks);
}

}  // namespace

RangePrediction inRow(RangePrediction of_one, double blocks) {
  FollowedPrediction& course = of_one.course;
  for (std::vector<double>* voltages : {&course.voltage, &course.voltage_lower, &course.voltage_upper, &course.equations_voltage})
    scale(*voltages, blocks);
  PredictionReport& report = of_one.report;
  scale(report.from_current, blocks);
  scale(report.naive, blocks);
  if (report.both_ways) scale(*report.both_ways, blocks);
  if (report.naive_from_current) scale(*report.naive_from_current, blocks);
  return of_one;
}

SessionEvents inRow(SessionEvents of_one, double blocks) {
  for (CrankComparison& crank : of_one.cranks) {
    scale(crank.measured_minimum, blocks);
    scale(crank.expected_minimum, blocks);
    scale(crank.modelled_minimum, blocks);
    if (crank.naive_minimum) scale(*crank.naive_minimum, blocks);
  }
  for (ChargeComparison& charge : of_one.charges) {
    scale(charge.mean_voltage, blocks);
    scale(charge.first_voltage, blocks);
  }
  return of_one;
}

SessionStatus inRow(SessionStatus of_one, double blocks) {
  if (of_one.expected) scale(of_one.expected->voltage, blocks);
  if (of_one.contest)
    for (double* voltage : {&of_one.contest->base_rmse, &of_one.contest->extended_rmse, &of_one.contest->base_crank_error,
                            &of_one.contest->extended_crank_error})
      scale(*voltage, blocks);
  scale(of_one.crank_contest.model_error, blocks);
  scale(of_one.crank_contest.naive_error, blocks);
  return of_one;
}

}  // namespace battery_sof
