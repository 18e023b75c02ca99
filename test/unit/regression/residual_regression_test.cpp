#include "regression/residual_regression.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

using Moment = InputMemory::Moment;

/// 20 s of load, 40 s at a source of changing voltage, over and over at 1 Hz.
std::vector<Moment> startStop(std::size_t samples, std::uint64_t seed = 3) {
  test::Random random(seed);
  std::vector<Moment> drive;
  double load = -15.0, level = 14.0;
  for (std::size_t n = 0; n < samples; ++n) {
    const double phase = std::fmod(static_cast<double>(n), 60.0);
    if (phase == 0.0) {
      load = random.uniform(-30.0, -8.0);
      level = random.uniform(13.2, 14.4);
    }
    const bool source = phase >= 20.0;
    drive.push_back(
        {n == 0 ? 0.0 : 1.0, source, source ? level + 0.02 * random.normal() : 12.3 + 0.01 * load,
         source ? 2.0 + 20.0 * std::exp(-(phase - 20.0) / 10.0) : load + random.normal()});
  }
  return drive;
}

/// Columns of a drive with an error of each sample.
template <typename Error>
ResidualSamples samplesOf(const std::vector<Moment>& drive, Error&& error) {
  InputMemory memory;
  ResidualSamples samples;
  for (const Moment& moment : drive) {
    samples.columns.push_back(memory.advance(moment));
    samples.error.push_back(error(moment, samples.columns.back()));
    samples.voltage_controlled.push_back(moment.voltage_controlled);
  }
  return samples;
}

double meanSquare(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return sum / static_cast<double>(values.size());
}

TEST(InputMemory, ComesBackFromItsNumbersAndGoesOnAsItWould) {
  const std::vector<Moment> drive = startStop(200);
  InputMemory memory;
  for (std::size_t n = 0; n < 137; ++n) memory.advance(drive[n]);
  ASSERT_EQ(memory.numbers().size(), InputMemory::kNumbers);
  InputMemory back = InputMemory::fromNumbers(memory.numbers());
  EXPECT_EQ(back.numbers(), memory.numbers());
  EXPECT_TRUE(back.begun);
  for (std::size_t n = 137; n < drive.size(); ++n)
    EXPECT_EQ(back.advance(drive[n]), memory.advance(drive[n])) << n;
  EXPECT_FALSE(InputMemory::fromNumbers(InputMemory().numbers()).begun);
}

TEST(InputMemory, RefusesAnotherNumberOfNumbers) {
  EXPECT_THROW(InputMemory::fromNumbers(std::vector<double>(InputMemory::kNumbers - 1, 0.0)),
               std::invalid_argument);
  EXPECT_THROW(InputMemory::fromNumbers({}), std::invalid_argument);
}

TEST(InputMemory, HasItsOwnColumnsForEachOfTheTwoQuantities) {
  InputMemory memory;
  for (const Moment& moment : startStop(100)) {
    const Eigen::VectorXd columns = memory.advance(moment);
    EXPECT_EQ(columns.size(), moment.voltage_controlled ? InputMemory::kCurrentColumns
                                                        : InputMemory::kVoltageColumns);
    EXPECT_TRUE(columns.allFinite());
  }
}

TEST(InputMemory, LaterSamplesChangeNoEarlierColumns) {
  std::vector<Moment> drive = startStop(300), changed = drive;
  for (std::size_t n = 150; n < changed.size(); ++n) {
    changed[n].voltage += 1.0;
    changed[n].current -= 30.0;
    changed[n].voltage_controlled = !changed[n].voltage_controlled;
  }
  InputMemory one, other;
  for (std::size_t n = 0; n < 150; ++n)
    ASSERT_EQ(one.advance(drive[n]), other.advance(changed[n])) << n;
}

TEST(InputMemory, CountsTheTimesSinceEachOfTheTwoDrove) {
  InputMemory memory;
  memory.advance({0.0, false, 12.3, -20.0});
  for (int n = 0; n < 7; ++n) memory.advance({1.0, true, 14.0, 5.0});
  EXPECT_DOUBLE_EQ(memory.since_discharge, 7.0);
  EXPECT_DOUBLE_EQ(memory.since_source, 0.0);
  for (int n = 0; n < 4; ++n) memory.advance({0.5, false, 12.2, -20.0});
  EXPECT_DOUBLE_EQ(memory.since_discharge, 0.0);
  EXPECT_DOUBLE_EQ(memory.since_source, 2.0);
}

TEST(InputMemory, LowPassesOfAHeldDriveEndAtIt) {
  InputMemory memory;
  for (int n = 0; n < 5000; ++n) memory.advance({1.0, false, 12.1, -20.0});
  for (const double u : memory.voltage) EXPECT_NEAR(u, 12.1, 1e-9);
  for (const double i : memory.discharge) EXPECT_NEAR(i, 20.0, 1e-5);
  for (const double i : memory.current) EXPECT_NEAR(i, -20.0, 1e-9);
}

ResidualRegression fitted(const ResidualSamples& samples) {
  std::vector<double> left_out;
  return fitResidualRegression(samples, left_out);
}

TEST(FitResidualRegression, LearnsAnErrorThatItsColumnsHold) {
  // 4 A/V of what the low pass of 30 s is behind the voltage; 2 mOhm of the current.
  test::Random random(21);
  const ResidualSamples samples =
      samplesOf(startStop(1800), [&](const Moment& moment, const Eigen::VectorXd& x) {
        return moment.voltage_controlled ? 4.0 * x[3] + 0.05 * random.normal()
                                         : 0.002 * x[0] + 0.001 * random.normal();
      });
  std::vector<double> left_out;
  const ResidualRegression residual_regression = fitResidualRegression(samples, left_out);
  ASSERT_FALSE(residual_regression.current.empty());
  ASSERT_FALSE(residual_regression.voltage.empty());
  EXPECT_GT(residual_regression.current.gain, 0.9);
  EXPECT_GT(residual_regression.voltage.gain, 0.9);
  ASSERT_EQ(left_out.size(), samples.error.size());
  for (const bool of_current : {true, false}) {
    std::vector<double> before, after;
    for (std::size_t n = 0; n < left_out.size(); ++n) {
      if (static_cast<bool>(samples.voltage_controlled[n]) != of_current) continue;
      before.push_back(samples.error[n]);
      after.push_back(samples.error[n] - left_out[n]);
    }
    EXPECT_LT(meanSquare(after), 0.1 * meanSquare(before));
  }
}

TEST(FitResidualRegression, LearnsNothingToSpeakOfFromNoise) {
  // Of ten draws of noise: what is estimated takes out at most a fiftieth of its square (9 columns,
  // 400 samples of a voltage), and in half of the cases or more nothing is.
  int empty = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    test::Random random(seed);
    const ResidualSamples samples =
        samplesOf(startStop(1200, seed),
                  [&](const Moment&, const Eigen::VectorXd&) { return random.normal(); });
    const ResidualRegression residual_regression = fitted(samples);
    empty += residual_regression.current.empty() ? 1 : 0;
    empty += residual_regression.voltage.empty() ? 1 : 0;
    EXPECT_LT(residual_regression.current.gain, 0.0225) << seed;
    EXPECT_LT(residual_regression.voltage.gain, 0.0225) << seed;
  }
  EXPECT_GE(empty, 10);
}

TEST(FitResidualRegression, LearnsNothingFromTooFewSamples) {
  const auto error = [](const Moment&, const Eigen::VectorXd& x) { return x[0]; };
  // 30 samples of a voltage are not there, nor 60 of a current.
  EXPECT_TRUE(fitted(samplesOf(startStop(65), error)).empty());
  const ResidualRegression residual_regression = fitted(samplesOf(startStop(110), error));
  EXPECT_FALSE(residual_regression.voltage.empty());  // 40 of them
  EXPECT_FALSE(residual_regression.current.empty());  // 70
  EXPECT_TRUE(fitted(ResidualSamples{}).empty());
}

TEST(FitResidualRegression, PredictionsOutsideTheWindowsRangeStayAtItsEnds) {
  const ResidualSamples samples =
      samplesOf(startStop(1200), [](const Moment& moment, const Eigen::VectorXd& x) {
        return moment.voltage_controlled ? x[0] : x[0] * 1e-3;
      });
  const ResidualRegression residual_regression = fitted(samples);
  Eigen::VectorXd far = residual_regression.voltage.upper;
  const double at_end = residual_regression.voltage.at(far);
  EXPECT_EQ(residual_regression.voltage.at(Eigen::VectorXd(far.array() + 1e4)), at_end);
}

}  // namespace
}  // namespace battery_sof
