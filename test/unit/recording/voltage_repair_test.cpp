#include "recording/voltage_repair.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

/// Loads that change every few seconds through 10 mOhm at 1 Hz, the voltage `lag` samples late; no
/// change of 0.25 V, as a drop-out's.
Series loads(std::size_t samples, std::size_t lag, double noise = 0.002) {
  test::Random random(8);
  Series series;
  double current = -10.0;
  std::vector<double> shown;
  for (std::size_t n = 0; n < samples; ++n) {
    if (random.uniform(0.0, 1.0) < 0.4) current = random.uniform(-12.0, 11.0);
    series.time.push_back(static_cast<double>(n));
    series.current.push_back(current);
    shown.push_back(12.5 + 0.01 * current);
    series.voltage.push_back(shown[n >= lag ? n - lag : 0] + noise * random.normal());
  }
  return series;
}

std::size_t countOf(const std::vector<char>& marks) {
  return static_cast<std::size_t>(std::count(marks.begin(), marks.end(), 1));
}

TEST(VoltageRepair, ReplacesADropOutByItsNeighboursMean) {
  Series series = loads(200, 0);
  for (const double apart : {-2.0, -0.6, 0.6}) {
    Series faulty = series;
    faulty.current[99] = faulty.current[100] = faulty.current[101] = -10.0;
    faulty.voltage[99] = 12.40;
    faulty.voltage[100] = 12.42 + apart;
    faulty.voltage[101] = 12.44;
    const VoltageRepair repair = findVoltageRepair(faulty);
    EXPECT_EQ(repair.dropped[100], 1) << apart;
    EXPECT_EQ(countOf(repair.dropped), 1u) << apart;
    const Series sound = repaired(faulty, repair);
    EXPECT_NEAR(sound.voltage[100], 12.42, 1e-12);
    faulty.voltage[100] = sound.voltage[100];
    EXPECT_EQ(sound.voltage, faulty.voltage);
    EXPECT_EQ(sound.current, faulty.current);
  }
}

TEST(VoltageRepair, ALostMessageThatReadsACurrentOfZeroIsADropOut) {
  Series series = loads(200, 0);
  series.current[99] = series.current[101] = -18.0;
  series.current[100] = 0.0;
  series.voltage[99] = series.voltage[101] = 12.3;
  series.voltage[100] = 0.0;
  EXPECT_TRUE(isDropOut(series, 100));
}

TEST(VoltageRepair, ACrankIsNoDropOut) {
  Series series = loads(200, 0);
  series.current[99] = series.current[101] = -10.0;
  series.current[100] = -180.0;
  series.voltage[99] = series.voltage[101] = 12.4;
  series.voltage[100] = 10.2;
  EXPECT_EQ(countOf(findVoltageRepair(series).dropped), 0u);
  // A load of 50 A for a sample explains its own dip.
  series.current[100] = -50.0;
  series.voltage[100] = 12.0;
  EXPECT_FALSE(isDropOut(series, 100));
}

TEST(VoltageRepair, AStepThatStaysIsNoDropOut) {
  Series series = loads(200, 0);
  std::fill(series.current.begin() + 90, series.current.begin() + 110, 3.0);
  for (std::size_t n = 100; n < 110; ++n) series.voltage[n] = 14.2;  // a source came
  for (std::size_t n = 90; n < 100; ++n) series.voltage[n] = 12.5;
  for (std::size_t n = 95; n < 105; ++n) EXPECT_FALSE(isDropOut(series, n)) << n;
  EXPECT_FALSE(isDropOut(series, 0));
  EXPECT_FALSE(isDropOut(series, series.size() - 1));
}

TEST(VoltageRepair, FindsALagAndUndoesIt) {
  for (const std::size_t lag : {1u, 2u}) {
    const Series late = loads(400, lag, 0.0), prompt = loads(400, 0, 0.0);
    const VoltageRepair repair = findVoltageRepair(late);
    ASSERT_EQ(repair.lag, lag);
    const Series sound = repaired(late, repair);
    for (std::size_t n = 0; n + lag < sound.size(); ++n)
      ASSERT_DOUBLE_EQ(sound.voltage[n], prompt.voltage[n]) << n;
    EXPECT_EQ(sound.voltage.back(), late.voltage.back());
    EXPECT_EQ(sound.time, late.time);
  }
}

TEST(VoltageRepair, FindsNoLagInAPromptChannelNorInAVoltageThatIsAhead) {
  EXPECT_EQ(findVoltageRepair(loads(400, 0)).lag, 0u);
  Series ahead = loads(400, 1);
  // One sample late by the current instead.
  std::rotate(ahead.current.rbegin(), ahead.current.rbegin() + 2, ahead.current.rend());
  EXPECT_EQ(findVoltageRepair(ahead).lag, 0u);
}

TEST(VoltageRepair, FindsNoLagBelowACorrelationOfThreeTenths) {
  // A voltage that is a source's and says nothing of the current.
  Series series = loads(400, 2);
  test::Random random(9);
  for (double& u : series.voltage) u = 14.0 + 0.1 * random.normal();
  EXPECT_EQ(findVoltageRepair(series).lag, 0u);
}

TEST(VoltageRepair, RefusesMarksOfAnotherSizeAndTakesAnEmptySeries) {
  VoltageRepair repair;
  repair.dropped.assign(3, 0);
  EXPECT_THROW(repaired(loads(10, 0), repair), std::invalid_argument);
  EXPECT_EQ(findVoltageRepair({}).lag, 0u);
  EXPECT_TRUE(repaired({}, {}).empty());
}

}  // namespace
}  // namespace battery_sof
