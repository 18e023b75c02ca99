#include "estimation/base_normal_equations.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "support/base_columns.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

constexpr OverpotentialSweep::Point kPoint{900.0, 25.0, 0.03};
const Eigen::Vector3d kLinear(0.0061, 0.0083, 12.71);

TEST(BaseJacobian, IsThatOfTheColumnsStepByStepWhateverTheBlocksHold) {
  for (const double duration : {0.31, 2.56, 5.12, 5.13, 7.67, 33.0}) {
    const Series series = test::baseDrive(9, duration);
    std::vector<char> masked(series.size(), 0);
    masked[7] = 1;
    const WindowSamples window{series, {0, series.size()}, {}, gapThreshold(series), masked};
    const auto samples = window.copied();
    const BaseJacobian whole = BaseNormalEquations(window, 1.0).jacobian(kPoint, kLinear);
    const test::BaseColumns columns = test::columnsOf(samples, kPoint, 0.0);
    const Eigen::Index count = columns.rows();
    ASSERT_EQ(whole.columns.rows(), count);
    EXPECT_LT((whole.columns - columns.leftCols(kColumnTarget)).cwiseAbs().maxCoeff(), 1e-10);
    const Eigen::VectorXd residual = columns.col(kColumnTarget) - columns.leftCols<3>() * kLinear;
    EXPECT_LT((whole.residual - residual).cwiseAbs().maxCoeff(), 1e-12);
    for (std::size_t n = 0; n < samples.size(); ++n)
      ASSERT_EQ(whole.weight[static_cast<Eigen::Index>(n)], samples[n].weight);
    EXPECT_EQ(whole.weight[7], 0.0);
    EXPECT_NEAR(whole.last.d_c2, columns(count - 1, kColumnLogC2) / kPoint.c2, 1e-15);
    EXPECT_NEAR(whole.last.d_beta, columns(count - 1, kColumnLogBeta) / kPoint.beta, 1e-12);
    EXPECT_NEAR(whole.last.d_initial, columns(count - 1, kColumnInitial), 1e-12);
  }
}

TEST(WindowSamples, AddUpAsTheirCopiesDo) {
  const Series series = test::baseDrive(2, 10.03);
  const std::vector<char> none;
  const WindowSamples window{series, {3, series.size()}, {}, 5.0, none};
  const auto copies = window.copied();
  const auto fitted = test::fitSamples(series, {3, series.size()});
  ASSERT_EQ(copies.size(), fitted.size());
  for (std::size_t n = 0; n < copies.size(); ++n)
    EXPECT_EQ(copies[n].held.current, fitted[n].held.current);
  EXPECT_EQ(copies.front().held.duration, 0.0);
  for (const std::size_t factor : {1U, 7U, 10U, 20U}) {
    const auto a = coarsened(window, factor), b = coarsened(copies, factor);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      EXPECT_EQ(a[k].voltage, b[k].voltage) << "to the last digit: a search ends in the same place";
      EXPECT_EQ(a[k].held.current, b[k].held.current);
      EXPECT_EQ(a[k].weight, b[k].weight);
    }
  }
}

TEST(Coarsened, MeansAreHeldFromMiddleToMiddle) {
  const Series series = test::baseDrive(2, 1.05);
  const auto samples = test::fitSamples(series, {0, series.size()});
  const auto coarse = coarsened(samples, 10);
  ASSERT_EQ(coarse.size(), 11U);
  double charge = 0.0, duration = 0.0, voltage = 0.0;
  for (std::size_t n = 15; n < 25; ++n) {
    charge += samples[n].held.current * samples[n].held.duration;
    duration += samples[n].held.duration;
    voltage += samples[n + 5].voltage / 10.0;
  }
  EXPECT_NEAR(coarse[2].held.duration, duration, 1e-12);
  EXPECT_NEAR(coarse[2].held.current, charge / duration, 1e-10);
  EXPECT_NEAR(coarse[2].voltage, voltage, 1e-12);
  EXPECT_NEAR(coarse[10].held.duration, 0.08, 1e-12)
      << "the last five samples: from sample 95 to the middle of five";
}

}  // namespace
}  // namespace battery_sof
