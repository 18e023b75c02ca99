#include "regression/evidence.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

Eigen::MatrixXd drawn(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  test::Random random(seed);
  Eigen::MatrixXd values(rows, columns);
  for (Eigen::Index k = 0; k < values.size(); ++k) values.data()[k] = random.normal();
  return values;
}

/// @param known_std of the first columns.  @param group of the others.
LinearProblem problemOf(const Eigen::MatrixXd& A, const Eigen::VectorXd& y,
                        const Eigen::VectorXd& known_std, const std::vector<int>& group) {
  LinearProblem problem;
  problem.products = A.transpose() * A;
  problem.targets = A.transpose() * y;
  problem.square = y.squaredNorm();
  problem.rows = static_cast<double>(y.size());
  problem.known_std = known_std;
  problem.group = group;
  for (const int g : group) problem.groups = std::max(problem.groups, g + 1);
  return problem;
}

/// ln N(y; 0, s^2 + A D^2 A'), by the covariance of the rows themselves.
double denseLogLikelihood(const Eigen::MatrixXd& A, const Eigen::VectorXd& y,
                          const Eigen::VectorXd& deviation, double noise) {
  Eigen::MatrixXd C = A * deviation.cwiseAbs2().asDiagonal() * A.transpose();
  C.diagonal().array() += noise * noise;
  const Eigen::LLT<Eigen::MatrixXd> llt(C);
  const double log_determinant = 2.0 * llt.matrixLLT().diagonal().array().log().sum();
  return -0.5 * (static_cast<double>(y.size()) * std::log(2.0 * M_PI) + log_determinant +
                 y.dot(llt.solve(y)));
}

double logPrior(const std::vector<double>& strength) {
  double sum = 0.0;
  for (const double s : strength) sum -= 0.5 * std::log1p(std::pow(s / GroupPrior::kScale, 2));
  return sum;
}

/// A known column and two groups of one, some millivolts each.
struct Tiny {
  Eigen::MatrixXd A = drawn(5, 3, 1);
  Eigen::VectorXd y = 1e-3 * (A * Eigen::Vector3d(3.0, -4.0, 2.0) + drawn(5, 1, 2));
  LinearProblem problem = problemOf(A, y, Eigen::VectorXd::Constant(1, 0.005), {0, 1});
};

TEST(FitSomeGroups, OfColumnsWhoseProductsAreNoNumbersHasNoEvidence) {
  Eigen::MatrixXd A = drawn(50, 4, 3);
  const Eigen::VectorXd y = drawn(50, 1, 4).col(0);
  for (const double size : {1e150, 1e200}) {
    A.col(1).setConstant(size);
    const LinearFit fit =
        fitSomeGroups(problemOf(A, y, Eigen::Vector2d(1.0, 1.0), {0, 1}), 0.5, {1, 1});
    EXPECT_TRUE(fit.z.allFinite()) << size;
    EXPECT_FALSE(std::isnan(fit.evidence)) << size;
    EXPECT_EQ(fit.strength.size(), 2u);
  }
  EXPECT_EQ(fitSomeGroups(problemOf(A, y, Eigen::Vector2d(1.0, 1.0), {0, 1}), 0.5, {1, 1}).evidence,
            -std::numeric_limits<double>::infinity());
}

/// Products of columns that are large and nearly alike contradict each other in their last digits.
TEST(FitSomeGroups, IsNeverLikelierThanAFitWithoutErrorsAtTheLeastNoise) {
  const Eigen::VectorXd y = 1e-3 * drawn(50, 1, 4).col(0);
  const double without_errors = -0.5 * 50.0 * std::log(2.0 * M_PI * 3e-5 * 3e-5);
  Eigen::MatrixXd A = drawn(50, 4, 3);
  A.col(0) = 1e6 * y;
  A.col(1) = A.col(0);
  LinearProblem problem = problemOf(A, y, Eigen::Vector2d(1.0, 1.0), {0, 1});
  problem.targets[0] *= 1.0 + 1e-6;
  problem.targets[1] *= 1.0 - 1e-6;
  const LinearFit fit = fitSomeGroups(problem, 1.0, {1, 1});
  EXPECT_LE(fit.evidence, without_errors);
  EXPECT_TRUE(fit.z.allFinite());
}

TEST(Evidence, EqualsTheDenseFormula) {
  const Tiny tiny;
  const LinearFit fit = fitSomeGroups(tiny.problem, 1.0, {1, 1});
  const Eigen::Vector3d deviation(0.005, fit.strength[0], fit.strength[1]);
  EXPECT_NEAR(denseLogLikelihood(tiny.A, tiny.y, deviation, fit.noise) + logPrior(fit.strength),
              fit.evidence, 1e-9);
}

TEST(Evidence, TemperedEqualsThatOfAsManyRowsAsCount) {
  const Tiny tiny;
  const double effective_sample_fraction = 0.3;
  const LinearFit fit = fitSomeGroups(tiny.problem, effective_sample_fraction, {1, 1});
  const Eigen::Vector3d D(0.005, fit.strength[0], fit.strength[1]);
  const Eigen::Matrix3d B =
      Eigen::Matrix3d::Identity() +
      Eigen::Matrix3d(effective_sample_fraction / (fit.noise * fit.noise) * D.asDiagonal() *
                      tiny.problem.products * D.asDiagonal());
  const Eigen::Vector3d h =
      effective_sample_fraction / (fit.noise * fit.noise) * D.cwiseProduct(tiny.problem.targets);
  const double expected =
      -0.5 * effective_sample_fraction * 5.0 * std::log(2.0 * M_PI * fit.noise * fit.noise) -
      0.5 * effective_sample_fraction * tiny.problem.square / (fit.noise * fit.noise) +
      0.5 * h.dot(B.inverse() * h) - 0.5 * std::log(B.determinant());
  EXPECT_NEAR(expected + logPrior(fit.strength), fit.evidence, 1e-9);
}

TEST(Evidence, MeanAndCovarianceAreThePosteriors) {
  const Tiny tiny;
  const LinearFit fit = fitSomeGroups(tiny.problem, 1.0, {1, 1});
  const Eigen::Vector3d deviation(0.005, fit.strength[0], fit.strength[1]);
  const Eigen::Matrix3d precision =
      tiny.problem.products / (fit.noise * fit.noise) +
      Eigen::Matrix3d(deviation.cwiseAbs2().cwiseInverse().asDiagonal());
  const Eigen::Matrix3d covariance = precision.inverse();
  EXPECT_LT((covariance - covarianceOf(tiny.problem, 1.0, fit)).norm(), 1e-9 * covariance.norm());
  EXPECT_LT((covariance * tiny.problem.targets / (fit.noise * fit.noise) - fit.z).norm(),
            1e-9 * fit.z.norm());
}

/// Two groups of five columns: one there, one not.
struct Grouped {
  Eigen::MatrixXd A = drawn(600, 12, 3);
  Eigen::VectorXd truth = Eigen::VectorXd::Zero(12);
  LinearProblem problem;

  Grouped() {
    truth << 0.02, -0.01, 5e-3, -4e-3, 6e-3, -5e-3, 4e-3, 0.0, 0.0, 0.0, 0.0, 0.0;
    problem = problemOf(A, A * truth + 1e-3 * drawn(600, 1, 4).col(0),
                        Eigen::VectorXd::Constant(2, 0.1), {0, 0, 0, 0, 0, 1, 1, 1, 1, 1});
  }
};

TEST(FitGroups, SwitchesOffAGroupOfNoiseAndKeepsTheOneThatIsThere) {
  const Grouped grouped;
  const LinearFit fit = fitGroups(grouped.problem, 1.0);
  EXPECT_LT((fit.z - grouped.truth).cwiseAbs().maxCoeff(), 4.0 * 1e-3 / std::sqrt(600.0));
  EXPECT_NEAR(4.9e-3, fit.strength[0], 2.5e-3);
  EXPECT_LT(fit.strength[1], 0.01 * fit.strength[0]);
  EXPECT_NEAR(1e-3, fit.noise, 1e-4);
}

TEST(FitGroups, NoOtherStrengthOrNoiseIsMoreEvident) {
  const Grouped grouped;
  const LinearFit fit = fitGroups(grouped.problem, 1.0);
  const Eigen::VectorXd y = grouped.A * grouped.truth + 1e-3 * drawn(600, 1, 4).col(0);
  const auto evidenceAt = [&](double by_strength, double by_noise) {
    std::vector<double> strength = fit.strength;
    strength[0] *= by_strength;
    Eigen::VectorXd deviation = Eigen::VectorXd::Constant(12, 0.1);
    deviation.segment(2, 5).setConstant(strength[0]);
    deviation.tail(5).setConstant(strength[1]);
    return denseLogLikelihood(grouped.A, y, deviation, by_noise * fit.noise) + logPrior(strength);
  };
  EXPECT_NEAR(evidenceAt(1.0, 1.0), fit.evidence, 1e-6);
  for (const double by : {0.8, 1.25}) {
    EXPECT_GT(fit.evidence, evidenceAt(by, 1.0)) << by;
    EXPECT_GT(fit.evidence, evidenceAt(1.0, by)) << by;
  }
}

TEST(FitGroups, AGroupThatIsNotActiveStaysOut) {
  const Grouped grouped;
  const LinearFit fit = fitSomeGroups(grouped.problem, 1.0, {0, 1});
  EXPECT_EQ(0.0, fit.strength[0]);
  EXPECT_TRUE(fit.z.segment(2, 5).isZero(0.0));
  EXPECT_LT(fit.evidence + 100.0, fitGroups(grouped.problem, 1.0).evidence);
}

TEST(FitGroups, AGroupsStrengthStaysBelowItsOwnMost) {
  Grouped grouped;
  grouped.problem.most = {1e-3, 0.2};
  EXPECT_LE(fitGroups(grouped.problem, 1.0).strength[0], 1e-3);
}

TEST(FitSparse, FindsTheTrueColumnsFirst) {
  Eigen::MatrixXd A = drawn(500, 31, 5);
  A.col(9) = 0.8 * A.col(8) + 0.6 * A.col(9);  // stands in for a true one, less well
  Eigen::VectorXd truth = Eigen::VectorXd::Zero(31);
  truth[0] = 0.02;
  truth[8] = 4e-3;
  truth[20] = -2e-3;
  const LinearProblem problem =
      problemOf(A, A * truth + 1e-3 * drawn(500, 1, 6).col(0), Eigen::VectorXd::Constant(1, 0.1),
                std::vector<int>(30, 0));
  const SparseFit sparse = fitSparse(problem, 1.0, 12);
  ASSERT_GE(sparse.path.size(), 2u);
  EXPECT_EQ(7, sparse.path[0].column);
  EXPECT_EQ(19, sparse.path[1].column);
  EXPECT_LE(sparse.path.size(), 5u) << "most columns hold nothing";
  EXPECT_LT((sparse.fit.z - truth).cwiseAbs().maxCoeff(), 4.0 * 1e-3 / std::sqrt(500.0));
  EXPECT_NEAR(1e-3, sparse.fit.noise, 1e-4);
}

TEST(FitSparse, TakesNoMoreColumnsThanItMay) {
  const Eigen::MatrixXd A = drawn(500, 11, 7);
  const LinearProblem problem =
      problemOf(A, A * Eigen::VectorXd::Constant(11, 5e-3) + 1e-3 * drawn(500, 1, 8).col(0),
                Eigen::VectorXd::Constant(1, 0.1), std::vector<int>(10, 0));
  EXPECT_EQ(3u, fitSparse(problem, 1.0, 3).path.size());
  EXPECT_EQ(10u, fitSparse(problem, 1.0, 12).path.size());
}

Eigen::VectorXd autoregressive(double rho, std::uint64_t seed) {
  Eigen::VectorXd e = drawn(60000, 1, seed).col(0);
  for (Eigen::Index n = 1; n < e.size(); ++n) e[n] += rho * e[n - 1];
  return e;
}

TEST(IndependentShare, OfWhiteNoiseIsNearOne) {
  EXPECT_NEAR(1.0, independentShare(autoregressive(0.0, 1)), 0.03);
}

TEST(IndependentShare, OfFirstOrderNoiseIsThatOfItsClosedForm) {
  for (const double rho : {0.5, 0.9, 0.98})
    EXPECT_NEAR(1.0, independentShare(autoregressive(rho, 2)) / ((1.0 - rho) / (1.0 + rho)), 0.2)
        << rho;
}

TEST(IndependentShare, IsBlindToAnOffset) {
  const Eigen::VectorXd e = autoregressive(0.9, 3);
  EXPECT_NEAR(independentShare(e), independentShare((e.array() + 100.0).matrix()), 1e-6);
}

}  // namespace
}  // namespace battery_sof
