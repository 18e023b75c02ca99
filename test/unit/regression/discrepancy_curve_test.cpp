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

TEST(CurveOf, AsksForNoCurrentThatItWasNotLearntFrom) {
  std::vector<double> currents;
  for (const DiscrepancyAtCurrent& at : curveOf(memoryOfCharging(), -12.0, 5.0))
    currents.push_back(at.current);
  EXPECT_EQ(currents, (std::vector<double>{-10.0, -5.0, -2.0, -1.0, 1.0, 2.0, 5.0}));
}

TEST(CurveOf, IsTheMemoryOfATenthOfASecondAndOfAMinute) {
  for (const DiscrepancyAtCurrent& at : curveOf(memoryOfCharging(), -20.0, 20.0)) {
    const double gain = 0.02 / 8.0 * std::max(at.current, 0.0);
    EXPECT_NEAR(at.early, -gain * std::expm1(-0.1 / 10.0), 1e-12) << at.current;
    EXPECT_GE(at.late, -gain * std::expm1(-40.0 / 10.0) - 1e-12) << at.current;
    EXPECT_LE(at.late, gain) << at.current;
  }
}

TEST(CurveOf, IsAsUncertainAsTheWeightAndSaysNothingWithoutItsCovariance) {
  DiscrepancyModel discrepancy = memoryOfCharging();
  EXPECT_FALSE(curveOf(discrepancy, -20.0, 20.0).back().late_std);
  discrepancy.covariance = Eigen::MatrixXd::Constant(1, 1, 0.002 * 0.002);  // a tenth of the weight
  for (const DiscrepancyAtCurrent& at : curveOf(discrepancy, -20.0, 20.0)) {
    EXPECT_NEAR(at.early_std.value(), 0.1 * at.early, 1e-12) << at.current;
    EXPECT_NEAR(at.late_std.value(), 0.1 * at.late, 1e-12) << at.current;
  }
}

TEST(CurveOf, StaysInsideWhatTheColumnSaw) {
  const std::vector<DiscrepancyAtCurrent> curve = curveOf(memoryOfCharging(), 0.0, 200.0);
  EXPECT_NEAR(curve.back().late, 0.02 / 8.0 * 30.0, 1e-12);
}

TEST(CurveOf, IsEmptyWhereNothingCanBeAnswered) {
  DiscrepancyModel discrepancy = memoryOfCharging();
  discrepancy.context.span = 0.1;
  EXPECT_TRUE(curveOf(discrepancy, -20.0, 20.0).empty());
  EXPECT_TRUE(curveOf(memoryOfCharging(), -0.5, 0.5).empty());
}

}  // namespace
}  // namespace battery_sof
