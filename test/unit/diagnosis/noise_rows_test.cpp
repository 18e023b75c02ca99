#include "diagnosis/timing_jitter_noise.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numeric>

#include "estimation/composition_fit.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

constexpr int kSamples = 60;
constexpr double kNoise = 0.002;  // [V]

/// Twelve steps of the current, a sample a second.
TimingJitterNoise noiseOfSteps() {
  Series series;
  for (int n = 0; n < kSamples; ++n) {
    series.time.push_back(n);
    series.current.push_back(n / 5 % 2 == 0 ? -30.0 : -10.0);
    series.voltage.push_back(12.6);
  }
  const InputSequence inputs = inputSequence(series, {0, kSamples});
  const BatteryModel circuit;
  const CompositionPoint base = typicalStart(circuit, inputs);
  const Linearization response =
      linearizationOf(circuit, {base.parameters, base.state, inputs.first_time, inputs.first_time},
                      inputs, inputs.samples.size());
  std::vector<Eigen::Index> counted(static_cast<std::size_t>(response.error.size()));
  std::iota(counted.begin(), counted.end(), 0);
  return {inputs, response, counted};
}

/// A column with a known prior, four of a group, and rows that hold some of each with a
/// pseudo-random noise.
struct Rows {
  Rows() : columns(kSamples, 5), targets(kSamples) {
    for (Eigen::Index n = 0; n < kSamples; ++n) {
      const auto t = static_cast<double>(n);
      columns.row(n) << 1.0, std::sin(0.1 * t), std::cos(0.3 * t), std::sin(0.7 * t),
          std::cos(1.1 * t);
      targets[n] =
          0.01 + 0.02 * columns(n, 1) - 0.01 * columns(n, 3) + kNoise * std::sin(1.7 * t * t);
    }
    problem.products = columns.transpose() * columns;
    problem.targets = columns.transpose() * targets;
    problem.square = targets.squaredNorm();
    problem.rows = kSamples;
    problem.known_std = Eigen::VectorXd::Constant(1, 0.05);
    problem.group = {0, 0, 0, 0};
    problem.groups = 1;
    fit = fitSomeGroups(problem, 1.0, {1});
  }

  /// ln of the density of the rows at the level of noise where it is greatest, from their
  /// covariance.
  double density(const TimingJitterNoise& noise) const {
    Eigen::MatrixXd prior = columns * Eigen::VectorXd::Constant(5, fit.strength[0]).asDiagonal();
    prior.col(0) = columns.col(0) * problem.known_std[0];
    Eigen::MatrixXd whitener(kSamples, kSamples);
    for (Eigen::Index n = 0; n < kSamples; ++n)
      whitener.col(n) = noise.whitened(Eigen::VectorXd::Unit(kSamples, n));
    const Eigen::MatrixXd shape = (whitener.transpose() * whitener).inverse();
    double most = -1e300;
    for (double s = 0.1 * kNoise; s < 10.0 * kNoise; s *= 1.003) {
      const Eigen::LLT<Eigen::MatrixXd> factor(s * s * shape + prior * prior.transpose());
      most = std::max(most, -0.5 * kSamples * std::log(2.0 * M_PI) -
                                factor.matrixLLT().diagonal().array().log().sum() -
                                0.5 * targets.dot(factor.solve(targets)));
    }
    return most;
  }

  Eigen::MatrixXd columns;
  Eigen::VectorXd targets;
  LinearProblem problem;
  LinearFit fit;
};

NoiseRows fewOf(const Rows& rows, double effective_sample_fraction) {
  return {rows.columns * NoiseRows::directions(rows.problem, rows.fit, effective_sample_fraction),
          rows.targets, effective_sample_fraction, rows.fit.noise};
}

TEST(NoiseRows, HaveTheLikelihoodOfAllColumns) {
  const Rows rows;
  const NoiseRows few = fewOf(rows, 1.0);
  for (const auto& [jitter, charge] :
       {std::make_pair(0.0, 0.0), std::make_pair(0.01, 0.0), std::make_pair(0.003, 0.05)}) {
    const TimingJitterNoise noise = noiseOfSteps().with(jitter, charge);
    EXPECT_NEAR(rows.density(noise), few.evidence(noise), 0.01) << jitter << ", " << charge;
  }
}

TEST(NoiseRows, FewerIndependentRowsWeighLess) {
  const Rows rows;
  const auto gain = [&](double effective_sample_fraction) {
    const NoiseRows few = fewOf(rows, effective_sample_fraction);
    return few.evidence(noiseOfSteps()) - few.evidence(noiseOfSteps().with(0.1, 0.1));
  };
  EXPECT_GT(gain(1.0), 1.0);
  EXPECT_GT(gain(1.0), 2.0 * gain(0.3));
}

}  // namespace
}  // namespace battery_sof
