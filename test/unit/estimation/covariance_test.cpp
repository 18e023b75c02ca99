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

/// Rows a tenth of a second apart.
Eigen::VectorXd tenths(Eigen::Index n) {
  return Eigen::VectorXd::LinSpaced(n, 0.0, 0.1 * static_cast<double>(n - 1));
}

TEST(SandwichCovariance, OfFewRowsIsThatOfIndependentErrors) {
  const Eigen::Index n = 29;
  const Eigen::MatrixXd J = lineColumns(n);
  const Eigen::VectorXd e = noise(n, 0.5, 4);
  Eigen::VectorXd w = Eigen::VectorXd::Ones(n);
  w.segment(10, 5).setConstant(100.0);
  w[20] = 0.0;
  const Eigen::MatrixXd g = e.cwiseProduct(w).asDiagonal() * J;
  const Eigen::MatrixXd A = (J.transpose() * w.asDiagonal() * J).inverse();
  EXPECT_TRUE(
      combined(sandwichParts(J, e, w, tenths(n))).isApprox(A * g.transpose() * g * A, 1e-9));
}

/// Share of seeds in which the estimated intercept and slope (truth 0) lie within two standard
/// errors, of white noise and of noise that is correlated by `rho` from row to row.
double coverage(double white, double rho) {
  const Eigen::Index n = 2000;
  const Eigen::MatrixXd J = lineColumns(n);
  const Eigen::VectorXd w = Eigen::VectorXd::Ones(n);
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const Eigen::VectorXd y = noise(n, rho, seed) + white * noise(n, 0.0, 1000 + seed);
    const Eigen::VectorXd b = (J.transpose() * J).ldlt().solve(J.transpose() * y);
    const Eigen::VectorXd e = y - J * b;
    const Eigen::MatrixXd V = combined(sandwichParts(J, e, w, tenths(n)));
    for (int j = 0; j < 2; ++j) inside += std::abs(b[j]) < 2.0 * std::sqrt(V(j, j));
  }
  return inside / 800.0;
}

TEST(SandwichCovariance, HoldsItsPromiseForWhiteNoise) {
  EXPECT_NEAR(coverage(0.0, 0.0), 0.954, 0.025);
}

TEST(SandwichCovariance, HoldsItsPromiseForCorrelatedNoise) { EXPECT_GT(coverage(0.0, 0.9), 0.90); }

TEST(SandwichCovariance, HoldsItsPromiseForCorrelatedNoiseThatWhiteNoiseHides) {
  EXPECT_GT(coverage(4.0, 0.9), 0.90);
}

TEST(SandwichCovariance, LeavesAnEmptyColumnAtZero) {
  Eigen::MatrixXd J = lineColumns(100);
  J.col(1).setZero();
  const Eigen::MatrixXd V =
      combined(sandwichParts(J, noise(100, 0.0, 1), Eigen::VectorXd::Ones(100), tenths(100)));
  EXPECT_GT(V(0, 0), 0.0);
  EXPECT_DOUBLE_EQ(V(1, 1), 0.0);
}

TEST(LagOneCorrelation, RecoversTheCorrelationOfTheNoise) {
  EXPECT_NEAR(lagOneCorrelation(noise(20000, 0.8, 9)), 0.8, 0.02);
  EXPECT_NEAR(lagOneCorrelation(noise(20000, 0.0, 9)), 0.0, 0.03);
  EXPECT_DOUBLE_EQ(lagOneCorrelation(Eigen::VectorXd::Constant(10, 2.0)), 0.0);
}

}  // namespace
}  // namespace battery_sof
