#include "recording/current_flicker.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace battery_sof {
namespace {

/// Twenty seconds at 100 Hz: steps of 20 A every second, flicker on the current; the voltage
/// answers with 5 mOhm to the steps and to `seen` of the flicker.
Series steps(double flicker, double seen, double step = 20.0) {
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal;
  Series series;
  for (int k = 0; k < 2000; ++k) {
    const double held = (k / 100) % 2 == 0 ? step : -step, own = flicker * normal(generator);
    series.append(
        {0.01 * k, held + own, 12.5 + 0.005 * (held + seen * own) + 1e-5 * normal(generator)});
  }
  return series;
}

double departure(const Series& series, const Series& truth) {
  double squares = 0.0;
  for (std::size_t k = 0; k < series.size(); ++k)
    squares += std::pow(series.current[k] - truth.current[k], 2);
  return std::sqrt(squares / static_cast<double>(series.size()));
}

TEST(CurrentFlicker, NoiseThatTheVoltageDoesNotShowIsTheSensors) {
  const CurrentFlicker flicker = currentFlicker(steps(0.1, 0.0));
  EXPECT_LT(flicker.share, 0.05);
}

TEST(CurrentFlicker, RippleThatTheVoltageShowsIsReal) {
  EXPECT_GT(currentFlicker(steps(0.1, 1.0)).share, 0.9);
}

TEST(CurrentFlicker, SensorNoiseGoesAndStepsStay) {
  const Series measured = steps(0.1, 0.0), truth = steps(0.0, 0.0);
  const Series quiet = withoutSensorNoise(measured, currentFlicker(measured));
  EXPECT_LT(departure(quiet, truth), 0.5 * departure(measured, truth));
  for (std::size_t k = 1; k < quiet.size(); ++k)
    if (k % 100 == 0) {
      EXPECT_GT(std::abs(quiet.current[k] - quiet.current[k - 1]), 39.0) << k;
    }
}

TEST(CurrentFlicker, RealRippleIsKept) {
  const Series measured = steps(0.1, 1.0);
  const Series kept = withoutSensorNoise(measured, currentFlicker(measured));
  EXPECT_LT(departure(kept, measured), 0.02);
}

TEST(CurrentFlicker, SlowRecordingsStayAsTheyAre) {
  Series series = steps(0.1, 0.0);
  for (double& time : series.time) time *= 100.0;
  EXPECT_EQ(1.0, currentFlicker(series).share);
  EXPECT_EQ(series.current, withoutSensorNoise(series, currentFlicker(series)).current);
}

}  // namespace
}  // namespace battery_sof
