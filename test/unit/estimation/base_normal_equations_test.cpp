#include "estimation/base_normal_equations.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "estimation/base_search.hpp"
#include "support/base_columns.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

constexpr OverpotentialSweep::Point kPoint{900.0, 25.0, 0.03};
const Eigen::Vector3d kLinear(0.0061, 0.0083, 12.71);

/// What BaseResidual says, from stored columns.
struct Stored {
  Stored(const std::vector<BaseNormalEquations::Sample>& samples,
         const BaseNormalEquations& equations, const OverpotentialSweep::Point& point,
         const Eigen::Vector3d& linear) {
    const test::BaseColumns all = test::columnsOf(samples, point, equations.offset());
    columns = all.leftCols(kScoreColumns);
    residual = all.col(kColumnTarget) - linear[0] * all.col(0) - linear[1] * all.col(1);
    residual.array() -= linear[2] - equations.offset();
    weight.resize(residual.size());
    for (std::size_t n = 0; n < samples.size(); ++n)
      weight[static_cast<Eigen::Index>(n)] = samples[n].weight;
  }
  Eigen::MatrixXd columns;
  Eigen::VectorXd residual, weight;
};

/// Largest difference of two symmetric matrices, in units of the diagonal.
double differenceOf(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::VectorXd scale = b.diagonal().cwiseSqrt().cwiseInverse();
  return (scale.asDiagonal() * (a - b) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

TEST(BaseResidual, IsThatOfTheColumnsWhateverTheBlocksHold) {
  for (const double duration : {0.31, 2.56, 5.12, 5.13, 7.67, 33.0}) {
    const Series series = test::baseDrive(9, duration);
    const auto samples = test::fitSamples(series, {0, series.size()});
    const BaseNormalEquations equations(samples, 1.0);
    const Stored stored(samples, equations, kPoint, kLinear);
    const BaseResidual left = BaseNormalEquations(equations).residual(kPoint, kLinear);
    for (std::size_t n = 0; n < samples.size(); ++n)
      ASSERT_NEAR(left.at(n), stored.residual[static_cast<Eigen::Index>(n)], 1e-12);
    EXPECT_NEAR(left.squares() / stored.residual.squaredNorm(), 1.0, 1e-10);
    EXPECT_NEAR(left.lagOne(), lagOneCorrelation(stored.residual), 1e-9);
    EXPECT_LT(differenceOf(left.information, stored.columns.transpose() *
                                                 stored.weight.asDiagonal() * stored.columns),
              1e-10);
    const auto last = stored.columns.bottomRows(1);
    EXPECT_NEAR(left.last.d_c2, last(0, kColumnLogC2) / kPoint.c2, 1e-15);
    EXPECT_NEAR(left.last.d_beta, last(0, kColumnLogBeta) / kPoint.beta, 1e-12);
    EXPECT_NEAR(left.last.d_initial, last(0, kColumnInitial), 1e-12);
  }
}

TEST(BaseResidual, ANarrowKernelIsExact) {
  for (const double duration : {2.55, 2.56, 33.0}) {
    const Series series = test::baseDrive(9, duration);
    const auto samples = test::fitSamples(series, {0, series.size()});
    const BaseNormalEquations equations(samples, 1.0);
    const Stored stored(samples, equations, kPoint, kLinear);
    const BaseResidual left = BaseNormalEquations(equations).residual(kPoint, kLinear);
    for (const Eigen::Index width : {1, 2, 7, 31, 32})
      EXPECT_LT(
          differenceOf(left.bartlettProducts(width),
                       sandwichParts(stored.columns, stored.residual, stored.weight, width).B),
          1e-9)
          << duration << " s, width " << width;
  }
}

TEST(BaseResidual, AWideKernelOverSumsOfSamplesGivesTheSameStandardErrors) {
  // What a fit leaves of a drive whose battery is not the model's: residuals correlated over
  // seconds.
  double most = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Series series = test::baseDrive(seed, 60.0);
    const auto samples = test::fitSamples(series, {0, series.size()});
    const BaseNormalEquations equations(samples, 1.0);
    const Stored stored(samples, equations, kPoint, kLinear);
    const BaseResidual left = BaseNormalEquations(equations).residual(kPoint, kLinear);
    for (const Eigen::Index width : {33, 35, 42, 63, 150, 700, 1199}) {
      const Eigen::MatrixXd exact =
          combined(sandwichParts(stored.columns, stored.residual, stored.weight, width));
      const Eigen::MatrixXd quick = combined({left.information, left.bartlettProducts(width)});
      const Eigen::ArrayXd ratio = (quick.diagonal().array() / exact.diagonal().array()).sqrt();
      most = std::max(most, (ratio - 1.0).abs().maxCoeff());
    }
  }
  EXPECT_LT(most, 0.03);
}

TEST(BaseResidual, NoWeightNoScore) {
  const Series series = test::baseDrive(9, 20.0);
  std::vector<char> masked(series.size(), 0);
  std::fill(masked.begin() + 500, masked.begin() + 1500, 1);
  const WindowSamples window(series, {0, series.size()}, {}, 5.0, masked);
  const auto samples = window.copied();
  const BaseNormalEquations equations(window, 1.0);
  const Stored stored(samples, equations, kPoint, kLinear);
  EXPECT_EQ(stored.weight[700], 0.0);
  const BaseResidual left = BaseNormalEquations(equations).residual(kPoint, kLinear);
  EXPECT_LT(differenceOf(left.bartlettProducts(5),
                         sandwichParts(stored.columns, stored.residual, stored.weight, 5).B),
            1e-9);
  EXPECT_NEAR(left.squares() / stored.residual.squaredNorm(), 1.0, 1e-10);
}

TEST(ScoresKernel, IsTheSameWithEveryInstructionSet) {
  const Series series = test::baseDrive(9, 2.56);
  MeasuredBlock measured = {};
  OverpotentialStates states = {};
  DerivativeBlock derivatives = {};
  test::Random random(1);
  for (int n = 0; n < kBlockSize; ++n) {
    for (double* value :
         {measured.discharge, measured.charge, measured.voltage, measured.weight, states.u_c2,
          derivatives.d_log_c2, derivatives.d_log_beta, derivatives.d_initial})
      value[n] = random.normal();
  }
  const double linear[kLinearColumns] = {0.1, 0.2, 0.3};
  struct Result {
    MeasuredBlock left;
    ResidualSums residual;
    ScoreSums sums;
    MovingScores moving;
    ScoreProducts products;
  };
  const auto resultOf = [&](InstructionSet set) {
    Result result = {};
    result.left = measured;
    leaveResidual(states, linear, result.left, result.residual, set);
    addUpScores(result.left, derivatives, result.sums, set);
    addMovingProducts(result.left, derivatives, 5, result.moving, result.products, set);
    addMovingProducts(result.left, derivatives, 5, result.moving, result.products, set);
    return result;
  };
  const Result plain = resultOf(InstructionSet::kPlain);
  const auto near = [](const double* a, const double* b, int count) {
    for (int k = 0; k < count; ++k) ASSERT_NEAR(a[k], b[k], 1e-10 * (1.0 + std::abs(b[k])));
  };
  for (const auto set : {InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (set > widestInstructionSet()) continue;
    const Result other = resultOf(set);
    near(other.left.voltage, plain.left.voltage, kBlockSize);
    near(other.residual.residual, plain.residual.residual, 3 * kLanes);
    near(other.sums.scores[0][0], plain.sums.scores[0][0], kScoreSums * kScoreColumns * kLanes);
    for (int j = 0; j < kScoreColumns; ++j)
      near(other.products.sums[j][0], plain.products.sums[j][0], (j + 1) * kLanes);
  }
}

TEST(WindowSamples, AddUpAsTheirCopiesDo) {
  const Series series = test::baseDrive(2, 10.03);
  const std::vector<char> none;
  const WindowSamples window(series, {3, series.size()}, {}, 5.0, none);
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
