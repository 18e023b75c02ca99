#include "estimation/fit_quality.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

Eigen::MatrixXd lineColumns(Eigen::Index n) {
  Eigen::MatrixXd J(n, 2);
  J.col(0).setOnes();
  J.col(1) = Eigen::VectorXd::LinSpaced(n, -1.0, 1.0);
  return J;
}

/// The double sum of the header, term by term.
Eigen::MatrixXd bySums(const Eigen::MatrixXd& J, const Eigen::VectorXd& e, const Eigen::VectorXd& w,
                       Eigen::Index width) {
  const Eigen::MatrixXd g = (e.cwiseProduct(w)).asDiagonal() * J;
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(J.cols(), J.cols());
  for (Eigen::Index a = 0; a < J.rows(); ++a)
    for (Eigen::Index b = 0; b < J.rows(); ++b) {
      const double share = 1.0 - static_cast<double>(std::abs(a - b)) / static_cast<double>(width);
      if (share > 0.0) B += share * g.row(a).transpose() * g.row(b);
    }
  const Eigen::MatrixXd A = (J.transpose() * w.asDiagonal() * J).inverse();
  return A * B * A;
}

Eigen::VectorXd noise(Eigen::Index n, double rho, std::uint64_t seed) {
  test::Random random(seed);
  Eigen::VectorXd e(n);
  double state = random.normal() / std::sqrt(1.0 - rho * rho);
  for (Eigen::Index k = 0; k < n; ++k) {
    e[k] = state;
    state = rho * state + random.normal();
  }
  return e;
}

TEST(SandwichCovariance, IsTheBartlettWeightedDoubleSum) {
  const Eigen::Index n = 700;  // more than two of its internal blocks
  const Eigen::MatrixXd J = lineColumns(n);
  const Eigen::VectorXd e = noise(n, 0.5, 4);
  Eigen::VectorXd w = Eigen::VectorXd::Ones(n);
  w.segment(100, 50).setConstant(100.0);
  for (Eigen::Index width : {1, 7, 140})
    EXPECT_TRUE(combined(sandwichParts(J, e, w, width)).isApprox(bySums(J, e, w, width), 1e-9))
        << width;
}

/// Share of seeds in which the estimated intercept and slope (truth 0) lie within two standard
/// errors.
double coverage(double rho) {
  const Eigen::Index n = 2000;
  const Eigen::MatrixXd J = lineColumns(n);
  const Eigen::VectorXd w = Eigen::VectorXd::Ones(n);
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const Eigen::VectorXd y = noise(n, rho, seed);
    const Eigen::VectorXd b = (J.transpose() * J).ldlt().solve(J.transpose() * y);
    const Eigen::VectorXd e = y - J * b;
    const Eigen::MatrixXd V =
        combined(sandwichParts(J, e, w, bartlettWidth(lagOneCorrelation(e), n)));
    for (int j = 0; j < 2; ++j) inside += std::abs(b[j]) < 2.0 * std::sqrt(V(j, j));
  }
  return inside / 800.0;
}

TEST(SandwichCovariance, HoldsItsPromiseForWhiteNoise) { EXPECT_NEAR(coverage(0.0), 0.954, 0.025); }

TEST(SandwichCovariance, HoldsItsPromiseForCorrelatedNoise) { EXPECT_GT(coverage(0.9), 0.90); }

TEST(SandwichCovariance, LeavesAnEmptyColumnAtZero) {
  Eigen::MatrixXd J = lineColumns(100);
  J.col(1).setZero();
  const Eigen::MatrixXd V =
      combined(sandwichParts(J, noise(100, 0.0, 1), Eigen::VectorXd::Ones(100), 1));
  EXPECT_GT(V(0, 0), 0.0);
  EXPECT_DOUBLE_EQ(V(1, 1), 0.0);
}

TEST(BartlettWidth, GrowsWithCorrelationAndStaysBelowAFifthOfTheData) {
  EXPECT_EQ(bartlettWidth(0.0, 1000), 1);
  EXPECT_LT(bartlettWidth(0.5, 24000), bartlettWidth(0.99, 24000));
  EXPECT_LE(bartlettWidth(1.0, 1000), 200);
  EXPECT_GE(bartlettWidth(1.0, 3), 1);
}

TEST(LagOneCorrelation, RecoversTheCorrelationOfTheNoise) {
  EXPECT_NEAR(lagOneCorrelation(noise(20000, 0.8, 9)), 0.8, 0.02);
  EXPECT_NEAR(lagOneCorrelation(noise(20000, 0.0, 9)), 0.0, 0.03);
  EXPECT_DOUBLE_EQ(lagOneCorrelation(Eigen::VectorXd::Constant(10, 2.0)), 0.0);
}

}  // namespace
}  // namespace battery_sof
