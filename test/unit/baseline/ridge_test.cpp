#include "baseline/ridge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

/// Random steps of current through a resistance and a memory of tau = 10 s.
Series steps(std::size_t samples, double interval, double noise) {
  test::Random random(4);
  Series series;
  double current = 0.0, memory = 0.0;
  for (std::size_t k = 0; k < samples; ++k) {
    if (random.uniform(0.0, 1.0) < interval / 5.0) current = random.uniform(-40.0, 30.0);
    memory += (1.0 - std::exp(-interval / 10.0)) * (current - memory);
    series.append({interval * static_cast<double>(k), current,
                   12.5 + 0.006 * current + 0.01 * memory + noise * random.normal()});
  }
  return series;
}

double rmse(const Series& series, IndexRange range, const std::vector<double>& voltage) {
  double squares = 0.0;
  for (std::size_t k = range.first; k < range.last; ++k)
    squares += std::pow(series.voltage[k] - voltage[k - range.first], 2);
  return std::sqrt(squares / static_cast<double>(range.size()));
}

TEST(RidgeVoltage, LearnsAResistanceAndAMemoryAmongItsColumns) {
  const Series series = steps(4000, 1.0, 0.002);
  const IndexRange train{0, 3000}, test{3000, 4000};
  const std::vector<double> voltage = ridgeVoltage(series, train, test);
  ASSERT_EQ(voltage.size(), test.size());
  EXPECT_LT(rmse(series, test, voltage), 0.004);
}

TEST(RidgeVoltage, ReadsNoVoltageOutsideTheTrainingRange) {
  Series series = steps(1000, 1.0, 0.002);
  const IndexRange train{0, 700}, test{700, 1000};
  const auto before = ridgeVoltage(series, train, test);
  for (std::size_t k = 700; k < 1000; ++k) series.voltage[k] = 0.0;
  EXPECT_EQ(ridgeVoltage(series, train, test), before);
}

TEST(RidgeVoltage, NoiseAloneIsPredictedByItsMean) {
  Series series = steps(600, 1.0, 0.0);
  test::Random random(8);
  for (double& voltage : series.voltage) voltage = 12.6 + 0.05 * random.normal();
  const IndexRange train{0, 450}, test{450, 600};
  EXPECT_LT(rmse(series, test, ridgeVoltage(series, train, test)), 0.07);
}

TEST(RidgeVoltage, AConstantCurrentIsNoObstacle) {
  Series series = steps(300, 1.0, 0.001);
  for (double& current : series.current) current = -10.0;
  for (const double voltage : ridgeVoltage(series, {0, 200}, {200, 300}))
    EXPECT_TRUE(std::isfinite(voltage));
}

TEST(RidgeVoltage, VeryLongRangesAreThinned) {
  const Series series = steps(45000, 0.1, 0.002);
  EXPECT_LT(rmse(series, {42000, 45000}, ridgeVoltage(series, {0, 42000}, {42000, 45000})), 0.004);
}

TEST(RidgeVoltage, RefusesRangesThatAreEmptyShortOrOutside) {
  const Series series = steps(200, 1.0, 0.0);
  EXPECT_THROW(ridgeVoltage(series, {0, 20}, {20, 40}), std::invalid_argument);
  EXPECT_THROW(ridgeVoltage(series, {0, 100}, {100, 100}), std::invalid_argument);
  EXPECT_THROW(ridgeVoltage(series, {0, 100}, {100, 300}), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof
