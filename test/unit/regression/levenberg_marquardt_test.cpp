#include "regression/levenberg_marquardt.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

namespace battery_sof {
namespace {

/// A curve y = f(b, x) with data, the certified values and standard deviations of NIST's
/// Statistical Reference Datasets.
struct ReferenceProblem {
  const char* name;
  std::function<double(const Eigen::VectorXd&, double)> curve;
  std::vector<double> x, y, start, certified, deviation;
  double residual_sum;
};

double slope(const ReferenceProblem& problem, Eigen::VectorXd b, int j, double x) {
  const double h = 1e-6 * std::abs(b[j]);
  b[j] += h;
  const double above = problem.curve(b, x);
  b[j] -= 2.0 * h;
  return (above - problem.curve(b, x)) / (2.0 * h);
}

/// Normal equations in parameters relative to the start, so that all have the same magnitude.
EvaluateNormalEquations equationsOf(const ReferenceProblem& problem) {
  return [&problem](const Eigen::VectorXd& relative, NormalEquations& at) {
    const int p = static_cast<int>(problem.start.size());
    const Eigen::VectorXd b =
        relative.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(problem.start.data(), p));
    at = {0.0, Eigen::VectorXd::Zero(p), Eigen::MatrixXd::Zero(p, p)};
    for (std::size_t n = 0; n < problem.x.size(); ++n) {
      const double r = problem.curve(b, problem.x[n]) - problem.y[n];
      Eigen::VectorXd row(p);
      for (int j = 0; j < p; ++j) row[j] = slope(problem, b, j, problem.x[n]) * problem.start[j];
      at.cost += r * r;
      at.gradient += row * r;
      at.hessian += row * row.transpose();
    }
    return std::isfinite(at.cost);
  };
}

std::vector<ReferenceProblem> referenceProblems() {
  std::vector<ReferenceProblem> problems;
  problems.push_back(
      {"Misra1a (lower difficulty)",
       [](const Eigen::VectorXd& b, double x) { return b[0] * (1.0 - std::exp(-b[1] * x)); },
       {77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1,
        760.0},
       {10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47,
        81.78},
       {500.0, 0.0001},
       {2.3894212918e+02, 5.5015643181e-04},
       {2.7070075241e+00, 7.2668688436e-06},
       1.2455138894e-01});
  problems.push_back({"DanWood (lower difficulty)",
                      [](const Eigen::VectorXd& b, double x) { return b[0] * std::pow(x, b[1]); },
                      {1.309, 1.471, 1.490, 1.565, 1.611, 1.680},
                      {2.138, 3.421, 3.597, 4.340, 4.882, 5.660},
                      {1.0, 5.0},
                      {7.6886226176e-01, 3.8604055871e+00},
                      {1.8281973860e-02, 5.1726610913e-02},
                      4.3173084083e-03});
  problems.push_back(
      {"Rat42 (higher difficulty)",
       [](const Eigen::VectorXd& b, double x) { return b[0] / (1.0 + std::exp(b[1] - b[2] * x)); },
       {9.0, 14.0, 21.0, 28.0, 42.0, 57.0, 63.0, 70.0, 79.0},
       {8.930, 10.800, 18.590, 22.330, 39.350, 56.110, 61.730, 64.620, 67.080},
       {100.0, 1.0, 0.1},
       {7.2462237576e+01, 2.6180768402e+00, 6.7359200066e-02},
       {1.7340283401e+00, 8.8295217536e-02, 3.4465663377e-03},
       8.0565229338e+00});
  problems.push_back(
      {"MGH10 (higher difficulty)",
       [](const Eigen::VectorXd& b, double x) { return b[0] * std::exp(b[1] / (x + b[2])); },
       {50, 55, 60, 65, 70, 75, 80, 85, 90, 95, 100, 105, 110, 115, 120, 125},
       {34780, 28610, 23650, 19630, 16370, 13720, 11540, 9744, 8261, 7030, 6005, 5147, 4427, 3820,
        3307, 2872},
       {0.02, 4000.0, 250.0},
       {5.6096364710e-03, 6.1813463463e+03, 3.4522363462e+02},
       {1.5687892471e-04, 2.3309021107e+01, 7.8486103508e-01},
       8.7945855171e+01});
  return problems;
}

TEST(Minimize, ReachesNistsCertifiedValuesAndDeviations) {
  for (const auto& problem : referenceProblems()) {
    SCOPED_TRACE(problem.name);
    MinimizeOptions options;
    options.max_iterations = 500;
    options.gain_tolerance = 1e-14;
    const auto p = static_cast<Eigen::Index>(problem.start.size());
    const MinimizeResult found = minimize(equationsOf(problem), Eigen::VectorXd::Ones(p), options);
    EXPECT_NEAR(found.at.cost, problem.residual_sum, 1e-6 * problem.residual_sum);
    const double variance =
        found.at.cost / static_cast<double>(problem.x.size() - problem.start.size());
    const Eigen::MatrixXd covariance = variance * found.at.hessian.inverse();
    for (Eigen::Index j = 0; j < p; ++j) {
      EXPECT_NEAR(found.x[j] * problem.start[j], problem.certified[j], 1e-5 * problem.certified[j]);
      EXPECT_NEAR(std::sqrt(covariance(j, j)) * problem.start[j], problem.deviation[j],
                  1e-3 * problem.deviation[j]);
    }
  }
}

/// E = (x0 - 3)^2 + 10 (x1 + 2)^2
bool bowl(const Eigen::VectorXd& x, NormalEquations& at) {
  const Eigen::Vector2d r(x[0] - 3.0, std::sqrt(10.0) * (x[1] + 2.0));
  at = {r.squaredNorm(), Eigen::Vector2d(r[0], std::sqrt(10.0) * r[1]),
        Eigen::Vector2d(1.0, 10.0).asDiagonal()};
  return true;
}

TEST(Minimize, StopsAtTheBoundWhenTheOptimumLiesBeyond) {
  MinimizeOptions options;
  options.max_iterations = 100;
  options.lower = Eigen::Vector2d(-5.0, -1.0);
  options.upper = Eigen::Vector2d(5.0, 5.0);
  const MinimizeResult found = minimize(bowl, Eigen::Vector2d(0.0, 4.0), options);
  EXPECT_EQ(found.status, FitStatus::kConverged);
  EXPECT_NEAR(found.x[0], 3.0, 1e-3);
  EXPECT_DOUBLE_EQ(found.x[1], -1.0);
}

/// Damping after steps along E = x^2 that gain a share of what they promise; none: refused.
double dampingAfter(double initial, const std::vector<std::optional<double>>& gain_ratios) {
  std::size_t pass = 0;
  double cost = 1.0, x_before = 1.0;
  const auto evaluate = [&](const Eigen::VectorXd& x, NormalEquations& at) {
    if (pass++ > 0) {
      const std::optional<double>& ratio = gain_ratios[pass - 2];
      if (!ratio) return false;
      cost -= *ratio * (x_before * x_before - x[0] * x[0]);
    }
    x_before = x[0];
    at = {cost, x, Eigen::MatrixXd::Ones(1, 1)};
    return true;
  };
  MinimizeOptions options;
  options.initial_damping = initial;
  options.max_iterations = static_cast<int>(gain_ratios.size());
  return minimize(evaluate, Eigen::VectorXd::Ones(1), options).damping;
}

TEST(Minimize, DampsLessByAThirdAtMostAfterAPerfectStep) {
  EXPECT_NEAR(dampingAfter(1.0, {1.0}), 1.0 / 3.0, 1e-12);
}

TEST(Minimize, KeepsItsDampingAfterAStepThatGainsHalfOfThePrediction) {
  EXPECT_NEAR(dampingAfter(0.7, {0.5}), 0.7, 1e-12);
}

TEST(Minimize, DampsMoreWithEveryRefusalInARowAndCalmsDownAfterASuccess) {
  EXPECT_DOUBLE_EQ(dampingAfter(1.0, {std::nullopt}), 2.0);
  EXPECT_DOUBLE_EQ(dampingAfter(1.0, {std::nullopt, std::nullopt}), 8.0);
  EXPECT_NEAR(dampingAfter(1.0, {std::nullopt, std::nullopt, 0.5, std::nullopt}), 16.0, 1e-10);
}

TEST(Minimize, SaysWhenTheIterationsRanOut) {
  MinimizeOptions options;
  options.max_iterations = 2;
  options.initial_damping = 1e3;
  EXPECT_EQ(minimize(bowl, Eigen::Vector2d(0.0, 4.0), options).status, FitStatus::kIterationLimit);
}

TEST(Minimize, SaysWhenNoStepLowersTheCost) {
  // A gradient that points the wrong way: every step is refused.
  const auto wrong = [](const Eigen::VectorXd& x, NormalEquations& at) {
    at = {1.0 + x[0] * x[0], Eigen::VectorXd::Constant(1, -x[0] - 1.0),
          Eigen::MatrixXd::Ones(1, 1)};
    return true;
  };
  MinimizeOptions options;
  options.max_iterations = 500;
  EXPECT_EQ(minimize(wrong, Eigen::VectorXd::Constant(1, 1.0), options).status,
            FitStatus::kStalled);
}

TEST(Minimize, RefusesAStartWithoutAFiniteCost) {
  const auto undefined = [](const Eigen::VectorXd&, NormalEquations&) { return false; };
  EXPECT_THROW(minimize(undefined, Eigen::VectorXd::Zero(1), {}), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof
