#include "regression/discrepancy_curve.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace battery_sof {
namespace {

/// 2.5 mV/A of a low pass of the charging current over 10 s, held inside 0 to 30 A.
DiscrepancyModel memoryOfCharging() {
  DiscrepancyModel discrepancy;
  discrepancy.regressors = {{RegressorKind::kChargeMemory, Mechanism::kAcceptance, 10.0}};
  discrepancy.context.interval = 0.1;
  discrepancy.context.span = 600.0;
  discrepancy.lower = Eigen::VectorXd::Constant(1, 0.0);
  discrepancy.upper = Eigen::VectorXd::Constant(1, 30.0);
  discrepancy.centre = Eigen::VectorXd::Constant(1, 4.0);
  discrepancy.scale = Eigen::VectorXd::Constant(1, 8.0);
  discrepancy.weight = Eigen::VectorXd::Constant(1, 0.02);
  return discrepancy;
}

/// Currents between two that were driven for ever.
DrivenTime within(double least, double most) {
  return [=](double current) { return current >= least && current <= most ? 1e9 : 0.0; };
}

/// A discharge at 0.9 A for an hour after a charge that falls from 1.5 A to 0.1 A in a minute.
Series smallBattery() {
  Series series;
  for (int n = 0; n < 3660; ++n) {
    series.time.push_back(n);
    series.current.push_back(n < 60 ? 1.5 - 1.4 * n / 60.0 : -0.9);
    series.voltage.push_back(12.0);
  }
  return series;
}

TEST(DrivenTime, IsTheLongestStretchAtHalfTheSizeOfACurrentThatWasReached) {
  const Series series = smallBattery();
  const DrivenTime driven = drivenTimeOf(series, {0, series.size()});
  EXPECT_EQ(driven(20.0), 0.0);
  EXPECT_EQ(driven(-1.0), 0.0);
  EXPECT_NEAR(driven(-0.5), 3600.0, 1.0);
  EXPECT_NEAR(driven(1.0), 43.0, 1.0);
}

TEST(DrivenTime, EndsAtAGap) {
  Series series = smallBattery();
  for (std::size_t n = 1860; n < series.size(); ++n) series.time[n] += 7200.0;
  EXPECT_NEAR(drivenTimeOf(series, {0, series.size()})(-0.5), 1800.0, 10.0);
}

TEST(AnswerCurrent, IsOneThatBothDirectionsHeld) {
  const Series series = smallBattery();
  EXPECT_EQ(answerCurrentOf(drivenTimeOf(series, {0, series.size()})), 0.5);
  EXPECT_EQ(answerCurrentOf(within(-200.0, 60.0)), 20.0);
  EXPECT_EQ(answerCurrentOf(within(-12.0, 0.002)), 10.0);
  EXPECT_FALSE(answerCurrentOf(within(0.0, 0.0)));
}

TEST(AnswersOf, AreForNoCurrentAndNoTimeThatWasNotDriven) {
  const Series series = smallBattery();
  const DrivenTime driven = drivenTimeOf(series, {0, series.size()});
  bool has_charge = false, has_discharge = false;
  for (const DiscrepancyAnswer& answer : answersOf(memoryOfCharging(), 0.5, driven)) {
    EXPECT_LE(answer.time, 3601.0);
    EXPECT_EQ(std::isfinite(answer.charging), answer.time <= driven(0.5) + 1e-9) << answer.time;
    EXPECT_TRUE(std::isfinite(answer.discharging)) << answer.time;
    has_charge = has_charge || std::isfinite(answer.charging);
    has_discharge = has_discharge || answer.time > 1000.0;
  }
  EXPECT_TRUE(has_charge && has_discharge);
  EXPECT_TRUE(answersOf(memoryOfCharging(), 20.0, driven).empty());
}

TEST(CurveOf, AsksForNoCurrentThatItWasNotLearntFrom) {
  std::vector<double> currents;
  for (const DiscrepancyAtCurrent& at : curveOf(memoryOfCharging(), within(-12.0, 5.0)))
    currents.push_back(at.current);
  EXPECT_EQ(currents, (std::vector<double>{-10.0, -5.0, -2.0, -1.0, -0.5, -0.2, -0.1, 0.1, 0.2, 0.5,
                                           1.0, 2.0, 5.0}));
}

TEST(CurveOf, HasNoMinuteOfACrank) {
  const DrivenTime driven = [](double current) {
    return current >= -20.0 && current <= 0.0   ? 300.0
           : current >= -200.0 && current < 0.0 ? 0.8
                                                : 0.0;
  };
  for (const DiscrepancyAtCurrent& at : curveOf(memoryOfCharging(), driven)) {
    EXPECT_TRUE(std::isfinite(at.early)) << at.current;
    EXPECT_EQ(std::isfinite(at.late), at.current >= -20.0) << at.current;
  }
}

TEST(CurveOf, IsTheMemoryOfATenthOfASecondAndOfAMinute) {
  for (const DiscrepancyAtCurrent& at : curveOf(memoryOfCharging(), within(-20.0, 20.0))) {
    const double gain = 0.02 / 8.0 * std::max(at.current, 0.0);
    EXPECT_NEAR(at.early, -gain * std::expm1(-0.1 / 10.0), 1e-12) << at.current;
    EXPECT_GE(at.late, -gain * std::expm1(-40.0 / 10.0) - 1e-12) << at.current;
    EXPECT_LE(at.late, gain) << at.current;
  }
}

TEST(CurveOf, IsAsUncertainAsTheWeightAndSaysNothingWithoutItsCovariance) {
  DiscrepancyModel discrepancy = memoryOfCharging();
  EXPECT_FALSE(curveOf(discrepancy, within(-20.0, 20.0)).back().late_std);
  discrepancy.covariance = Eigen::MatrixXd::Constant(1, 1, 0.002 * 0.002);  // a tenth of the weight
  for (const DiscrepancyAtCurrent& at : curveOf(discrepancy, within(-20.0, 20.0))) {
    EXPECT_NEAR(at.early_std.value(), 0.1 * at.early, 1e-12) << at.current;
    EXPECT_NEAR(at.late_std.value(), 0.1 * at.late, 1e-12) << at.current;
  }
}

TEST(CurveOf, StaysInsideWhatTheColumnSaw) {
  const std::vector<DiscrepancyAtCurrent> curve = curveOf(memoryOfCharging(), within(0.0, 200.0));
  EXPECT_NEAR(curve.back().late, 0.02 / 8.0 * 30.0, 1e-12);
}

TEST(CurveOf, IsEmptyWhereNothingCanBeAnswered) {
  EXPECT_TRUE(curveOf(memoryOfCharging(), [](double) { return 0.05; }).empty());
  EXPECT_TRUE(curveOf(memoryOfCharging(), [](double) { return 0.0; }).empty());
}

}  // namespace
}  // namespace battery_sof
