#include "state/noise_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

const NoiseModel kTruth{0.002, 0.004, 3.0, 2e-4};

/// Steps of the given interval, every seventh three times as long, every fifth an average of four.
std::vector<InputSample> unevenSamples(int count, double interval) {
  std::vector<InputSample> samples(static_cast<std::size_t>(count));
  for (int n = 0; n < count; ++n) {
    samples[static_cast<std::size_t>(n)].step.duration = n == 0       ? 0.0
                                                         : n % 7 == 0 ? 3.0 * interval
                                                                      : interval;
    samples[static_cast<std::size_t>(n)].count = n % 5 == 0 ? 4.0 : 1.0;
  }
  return samples;
}

/// Noise made as the header says: a walk, an AR(1) and white noise.
Eigen::VectorXd simulated(const NoiseModel& noise, const std::vector<InputSample>& samples,
                          std::uint64_t seed) {
  test::Random random(seed);
  Eigen::VectorXd e(static_cast<Eigen::Index>(samples.size()));
  double d = 0.0, a = noise.ar_std * random.normal();
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const double dt = samples[n].step.duration;
    if (n > 0) {
      const double kept = std::exp(-dt / noise.ar_time);
      d += noise.walk_std * std::sqrt(dt) * random.normal();
      a = kept * a + noise.ar_std * std::sqrt(1.0 - kept * kept) * random.normal();
    }
    e[static_cast<Eigen::Index>(n)] =
        d + a + noise.white_std / std::sqrt(samples[n].count) * random.normal();
  }
  return e;
}

/// The noise's covariance of the samples, entry by entry.
Eigen::MatrixXd covarianceOf(const NoiseModel& noise, const std::vector<InputSample>& samples) {
  const auto size = static_cast<Eigen::Index>(samples.size());
  Eigen::VectorXd time(size);
  double t = 0.0;
  for (Eigen::Index n = 0; n < size; ++n)
    time[n] = t += samples[static_cast<std::size_t>(n)].step.duration;
  Eigen::MatrixXd V(size, size);
  for (Eigen::Index j = 0; j < size; ++j)
    for (Eigen::Index k = 0; k < size; ++k) {
      V(j, k) = std::pow(noise.walk_std, 2) * std::min(time[j], time[k]) +
                std::pow(noise.ar_std, 2) * std::exp(-std::abs(time[j] - time[k]) / noise.ar_time);
      if (j == k)
        V(j, k) += std::pow(noise.white_std, 2) / samples[static_cast<std::size_t>(j)].count;
    }
  return V;
}

TEST(Whitening, IsTheInverseCholeskyFactorOfTheNoisesCovariance) {
  const auto samples = unevenSamples(60, 0.2);
  const Whitening whitening(kTruth, samples);
  const Eigen::LLT<Eigen::MatrixXd> factor(covarianceOf(kTruth, samples));
  const Eigen::MatrixXd L = factor.matrixL();
  for (std::uint64_t seed : {1, 2, 3}) {
    const Eigen::VectorXd e = simulated(kTruth, samples, seed);
    EXPECT_TRUE(whitening.whitened(e).isApprox(L.triangularView<Eigen::Lower>().solve(e), 1e-9));
  }
  EXPECT_NEAR(whitening.logDeterminant(), 2.0 * L.diagonal().array().log().sum(), 1e-9);
}

TEST(Whitening, HasTheDeterminantOfTheSamplesItTakesIn) {
  auto samples = unevenSamples(60, 0.2);
  std::vector<int> taken;
  for (int n = 0; n < 60; ++n)
    if (n != 0 && n != 30) taken.push_back(n);
  const Eigen::MatrixXd V = covarianceOf(kTruth, samples)(taken, taken);
  const Eigen::MatrixXd L = Eigen::LLT<Eigen::MatrixXd>(V).matrixL();
  samples[0].count = samples[30].count = 0.0;
  EXPECT_NEAR(Whitening(kTruth, samples).logDeterminant(), 2.0 * L.diagonal().array().log().sum(),
              1e-9);
}

TEST(Whitening, TurnsItsNoiseIntoIndependentNumbersOfUnitVariance) {
  const auto samples = unevenSamples(20000, 0.1);
  const Eigen::VectorXd v = Whitening(kTruth, samples).whitened(simulated(kTruth, samples, 11));
  const double variance = v.squaredNorm() / static_cast<double>(v.size());
  EXPECT_NEAR(variance, 1.0, 0.03);  // three standard deviations of 20,000 squares
  EXPECT_NEAR(v.mean(), 0.0, 0.022);
  for (Eigen::Index lag : {1, 2, 3, 5, 10, 30, 100}) {
    const Eigen::Index n = v.size() - lag;
    const double correlation = v.head(n).dot(v.tail(n)) / static_cast<double>(n);
    EXPECT_NEAR(correlation, 0.0, 0.022) << "lag " << lag;
  }
}

TEST(Whitening, TreatsEveryColumnAlikeAndIsLinear) {
  const auto samples = unevenSamples(200, 0.1);
  const Whitening whitening(kTruth, samples);
  const Eigen::VectorXd a = simulated(kTruth, samples, 1), b = simulated(kTruth, samples, 2);
  EXPECT_TRUE(whitening.whitened(2.0 * a - 3.0 * b)
                  .isApprox(2.0 * whitening.whitened(a) - 3.0 * whitening.whitened(b), 1e-10));
  using Row = Eigen::Array2d;
  Whitening::Memory<Row> memory{Row::Zero(), Row::Zero()};
  const Eigen::VectorXd alone = whitening.whitened(b);
  for (Eigen::Index n = 0; n < a.size(); ++n) {
    Row row(a[n], b[n]);
    whitening.apply(static_cast<std::size_t>(n), row, memory);
    ASSERT_NEAR(row[1], alone[n], 1e-12);
  }
}

TEST(Whitening, OfWhiteNoiseAloneDividesByItsStandardDeviation) {
  const auto samples = unevenSamples(100, 0.1);
  const Eigen::VectorXd e = simulated(kTruth, samples, 4);
  const Eigen::VectorXd v = Whitening({0.002, 0.0, 1.0, 0.0}, samples).whitened(e);
  for (Eigen::Index n = 0; n < e.size(); ++n)
    ASSERT_NEAR(v[n], e[n] / 0.002 * std::sqrt(samples[static_cast<std::size_t>(n)].count), 1e-9);
}

TEST(Whitening, RefusesANoiseThatIsNoneAndNamesThePart) {
  const auto samples = unevenSamples(10, 0.1);
  const auto message = [&](NoiseModel noise) -> std::string {
    try {
      Whitening whitening(noise, samples);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message({0.0, 0.001, 1.0, 0.0}).find("white_std"), std::string::npos);
  EXPECT_NE(message({NAN, 0.001, 1.0, 0.0}).find("white_std"), std::string::npos);
  EXPECT_NE(message({0.001, -0.001, 1.0, 0.0}).find("ar_std"), std::string::npos);
  EXPECT_NE(message({0.001, 0.001, 0.0, 0.0}).find("ar_time"), std::string::npos);
  EXPECT_NE(message({0.001, 0.001, 1.0, INFINITY}).find("walk_std"), std::string::npos);
}

TEST(FitNoise, RecoversTheFourNumbersOfASeededNoise) {
  const auto samples = unevenSamples(12000, 0.1);
  for (std::uint64_t seed : {21, 22}) {
    const NoiseModel found = fitNoise(simulated(kTruth, samples, seed), samples);
    EXPECT_NEAR(found.white_std / kTruth.white_std, 1.0, 0.05);
    EXPECT_NEAR(found.ar_std / kTruth.ar_std, 1.0, 0.15);
    EXPECT_NEAR(found.ar_time / kTruth.ar_time, 1.0, 0.35);
    EXPECT_LT(found.walk_std, 3.0 * kTruth.walk_std);
  }
}

TEST(FitNoise, OfWhiteNoiseFindsNothingElse) {
  const auto samples = unevenSamples(8000, 0.05);
  const NoiseModel white{0.002, 0.0, 1.0, 0.0};
  const NoiseModel found = fitNoise(simulated(white, samples, 5), samples);
  EXPECT_NEAR(found.white_std, 0.002, 5e-5);
  EXPECT_LT(found.ar_std, 4e-4);
  EXPECT_LT(found.walk_std, 2e-4);
}

TEST(FitNoise, IsNoLessLikelyThanTheTruthAndThanAnyNeighbour) {
  const auto samples = unevenSamples(4000, 0.1);
  const Eigen::VectorXd e = simulated(kTruth, samples, 31);
  const NoiseModel found = fitNoise(e, samples);
  const double least = deviance(found, e, samples);
  EXPECT_LE(least, deviance(kTruth, e, samples));
  for (double factor : {0.9, 1.1}) {
    EXPECT_LE(least,
              deviance({factor * found.white_std, found.ar_std, found.ar_time, found.walk_std}, e,
                       samples) +
                  1e-3);
    EXPECT_LE(least,
              deviance({found.white_std, factor * found.ar_std, found.ar_time, found.walk_std}, e,
                       samples) +
                  1e-3);
    EXPECT_LE(least,
              deviance({found.white_std, found.ar_std, factor * found.ar_time, found.walk_std}, e,
                       samples) +
                  1e-3);
    EXPECT_LE(least,
              deviance({found.white_std, found.ar_std, found.ar_time, factor * found.walk_std}, e,
                       samples) +
                  1e-3);
  }
}

TEST(FitNoise, NeverFallsBelowWhatTheResolutionAdds) {
  const auto samples = unevenSamples(500, 0.1);
  Eigen::VectorXd smooth(500);
  for (Eigen::Index n = 0; n < 500; ++n) smooth[n] = 0.01 * std::sin(0.02 * static_cast<double>(n));
  EXPECT_GE(fitNoise(smooth, samples, 3e-4).white_std, 3e-4 * (1.0 - 1e-9));
  EXPECT_GE(fitNoise(Eigen::VectorXd::Zero(500), samples, 3e-4).white_std, 3e-4 * (1.0 - 1e-9));
}

TEST(FitNoise, RefusesTooFewSamplesAndSizesThatDiffer) {
  EXPECT_THROW(fitNoise(Eigen::VectorXd::Zero(29), unevenSamples(29, 0.1)), std::invalid_argument);
  EXPECT_THROW(fitNoise(Eigen::VectorXd::Zero(40), unevenSamples(41, 0.1)), std::invalid_argument);
}

TEST(Deviance, IsMinusTwiceTheLogarithmOfTheGaussianDensity) {
  const auto samples = unevenSamples(50, 0.1);
  const Eigen::VectorXd e = simulated(kTruth, samples, 6);
  const Eigen::MatrixXd V = covarianceOf(kTruth, samples);
  const Eigen::LLT<Eigen::MatrixXd> factor(V);
  const Eigen::MatrixXd L = factor.matrixL();
  EXPECT_NEAR(deviance(kTruth, e, samples),
              2.0 * L.diagonal().array().log().sum() + e.dot(factor.solve(e)), 1e-8);
}

}  // namespace
}  // namespace battery_sof
