#include "estimation/fit_quality.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace battery_sof {
namespace {

TEST(InformationInverse, LeavesOutWhatTheDataSayNothingOf) {
  const Eigen::Matrix2d only_the_sum{{1.0, 1.0}, {1.0, 1.0}};
  EXPECT_TRUE(informationInverse(only_the_sum).isApprox(0.25 * only_the_sum, 1e-9));
}

TEST(QDyn, IsHundredForAPerfectModelAndZeroForTheMean) {
  EXPECT_DOUBLE_EQ(*qDyn({12.0, 13.0, 14.0}, {12.0, 13.0, 14.0}), 100.0);
  EXPECT_NEAR(*qDyn({12.0, 13.0, 14.0}, {13.0, 13.0, 13.0}), 0.0, 1e-12);
}

TEST(QDyn, IsEquationSix) {
  // errors 0.5, 0, -0.5; deviations from the mean -1, 0, 1
  EXPECT_NEAR(*qDyn({12.0, 13.0, 14.0}, {11.5, 13.0, 14.5}), 50.0, 1e-12);
}

TEST(QDyn, IsNegativeWhenAConstantWouldDoBetter) {
  EXPECT_LT(*qDyn({12.0, 13.0}, {13.0, 12.0}), 0.0);
}

TEST(QDyn, IsUndefinedForAVoltageThatNeverChanges) {
  EXPECT_FALSE(qDyn({12.6, 12.6, 12.6}, {12.5, 12.6, 12.7}).has_value());
}

TEST(QDyn, RefusesDifferentLengthsAndNothing) {
  EXPECT_THROW(qDyn({12.0}, {12.0, 13.0}), std::invalid_argument);
  EXPECT_THROW(qDyn({}, {}), std::invalid_argument);
}

TEST(RootMeanSquareError, IsTheRootOfTheMeanSquare) {
  EXPECT_DOUBLE_EQ(rootMeanSquareError({1.0, 2.0}, {4.0, 6.0}), std::sqrt(12.5));
}

}  // namespace
}  // namespace battery_sof
