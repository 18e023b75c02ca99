#include "diagnosis/timing_jitter_noise.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numeric>

#include "estimation/composition_fit.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

constexpr int kSamples = 40;

/// Steps of 20 A between the third and the fourth sample and of 5 A between the tenth and the
/// eleventh.
Series stepped(double interval) {
  Series series;
  for (int n = 0; n < kSamples; ++n) {
    series.time.push_back(n * interval);
    series.current.push_back(n < 3 ? -30.0 : n < 10 ? -10.0 : -15.0);
    series.voltage.push_back(12.6);
  }
  return series;
}

struct Stepped {
  explicit Stepped(double interval = 1.0)
      : inputs(inputSequence(stepped(interval), {0, kSamples})) {
    const BatteryModel circuit;
    const CompositionPoint base = typicalStart(circuit, inputs);
    response = linearizationOf(circuit,
                               {base.parameters, base.state, inputs.first_time, inputs.first_time},
                               inputs, inputs.samples.size());
    counted.resize(static_cast<std::size_t>(response.error.size()));
    std::iota(counted.begin(), counted.end(), 0);
  }
  TimingJitterNoise noise() const { return {inputs, response, counted}; }

  InputSequence inputs;
  Linearization response;
  std::vector<Eigen::Index> counted;
};

/// Covariance of the rows over s^2, as the header has it.
Eigen::MatrixXd covarianceOf(const Stepped& rows, double jitter, double charge) {
  const auto count = static_cast<Eigen::Index>(rows.counted.size());
  // x of every row by what came at every row
  Eigen::MatrixXd brought = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd white = Eigen::VectorXd::Ones(count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const auto at = static_cast<std::size_t>(n);
    const auto current = [&](std::size_t k) { return rows.inputs.samples[k].step.current; };
    if (n > 0) {
      brought.row(n) = rows.response.persistence[n] * brought.row(n - 1);
      brought(n, n) =
          charge * std::abs(current(at) - current(at - 1)) * rows.inputs.samples[at].step.duration;
      white[n] += jitter * std::pow(current(at) - current(at - 1), 2);
    }
    if (n + 1 < count) white[n] += jitter * std::pow(current(at + 1) - current(at), 2);
  }
  Eigen::MatrixXd covariance = brought * brought.transpose();
  covariance.diagonal() += white;
  return covariance;
}

TEST(TimingJitterNoise, InnovationsHaveTheLikelihoodOfTheRowsCovariance) {
  const Stepped rows;
  Eigen::VectorXd error(kSamples);
  for (Eigen::Index n = 0; n < kSamples; ++n) error[n] = std::sin(1.7 * static_cast<double>(n * n));
  for (const auto& [jitter, charge] :
       {std::make_pair(0.01, 0.0), std::make_pair(0.0, 0.2), std::make_pair(0.003, 0.05)}) {
    const TimingJitterNoise noise = rows.noise().with(jitter, charge);
    const Eigen::LLT<Eigen::MatrixXd> factor(covarianceOf(rows, jitter, charge));
    EXPECT_NEAR(noise.whitened(error).squaredNorm(), error.dot(factor.solve(error)), 1e-9);
    EXPECT_NEAR(noise.logScale(), -factor.matrixLLT().diagonal().array().log().sum(), 1e-9);
  }
}

TEST(TimingJitterNoise, WithoutAnyRowsStayAsTheyAre) {
  const Stepped rows;
  const Eigen::VectorXd error = Eigen::VectorXd::LinSpaced(kSamples, -1.0, 1.0);
  EXPECT_TRUE(rows.noise().isWhite());
  EXPECT_EQ(rows.noise().whitened(error), error);
  EXPECT_EQ(rows.noise().logScale(), 0.0);
}

TEST(TimingJitterNoise, AFastRecordingSeesItsSteps) {
  EXPECT_TRUE(Stepped(1.0).noise().applies());
  EXPECT_FALSE(Stepped(0.01).noise().applies());
  EXPECT_FALSE(TimingJitterNoise().applies());
}

TEST(TimingJitterNoise, AGapIsNoStep) {
  Stepped rows;
  rows.inputs.samples[3].step.gap = true;
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(kSamples);
  const Eigen::VectorXd seen = rows.noise().with(1.0, 0.0).whitened(ones);
  EXPECT_EQ(seen[2], 1.0);
  EXPECT_EQ(seen[3], 1.0);
  EXPECT_LT(seen[9], 0.5);
}

TEST(TimingJitterNoise, TheBestIsWhereTheEvidenceIs) {
  const TimingJitterNoise best = Stepped().noise().best([](const TimingJitterNoise& noise) {
    const auto distance = [](double value, double wanted) {
      return std::abs(std::log10(std::max(value, 1e-9) / wanted));
    };
    return -distance(noise.jitter(), 3e-3) - distance(noise.charge(), 0.2);
  });
  EXPECT_NEAR(std::log10(best.jitter()), std::log10(3e-3), 0.26);
  EXPECT_NEAR(std::log10(best.charge()), std::log10(0.2), 0.26);
  EXPECT_TRUE(
      Stepped()
          .noise()
          .best([](const TimingJitterNoise& noise) { return -noise.jitter() - noise.charge(); })
          .isWhite());
}

TEST(TimingJitterNoise, ARowAsWideAsTheNoiseCountsHalf) {
  InputSequence inputs = inputSequence(stepped(1.0), {0, kSamples});
  inputs.samples[10].step.span = 0.1;
  const InputSequence weighed = TimingJitterNoise::weighed(inputs, 1.0 / 400.0);
  for (std::size_t n = 0; n < weighed.samples.size(); ++n) {
    const double expected = n == 2 || n == 3 ? 0.5 : n == 9 ? 1.0 / (1.0 + 25.0 / 400.0) : 1.0;
    EXPECT_NEAR(expected, weighed.samples[n].count, 1e-12) << n;
  }
}

}  // namespace
}  // namespace battery_sof
