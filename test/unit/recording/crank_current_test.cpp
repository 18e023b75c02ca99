#include "recording/crank_current.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <stdexcept>

#include "battery_sof/csv.hpp"

namespace battery_sof {
namespace {

/// A drive of two minutes at 10 Hz with consumers of 8 A, and pulses of 0.8 s in it.
Series driveWith(const std::vector<double>& pulses, double resistance = 0.02, double load = -8.0) {
  Series series;
  for (int k = 0; k < 1200; ++k) {
    const int phase = k % 100, pulse = k / 100;
    const bool is_pulse = phase >= 50 && phase < 58 && pulse < static_cast<int>(pulses.size());
    const double current = is_pulse ? pulses[static_cast<std::size_t>(pulse)] : load;
    series.append({0.1 * k, current, 12.6 + resistance * current});
  }
  return series;
}

std::size_t cranksIn(const Series& series, const CrankCurrent& crank) {
  return detectCranks(series, {0, series.size()}, EventLimits{crank.current}).size();
}

TEST(CrankCurrent, OfASmallEngineIsAShareOfItsLargestRepeatedPulses) {
  const Series series = driveWith({-120.0, -118.0, -125.0, -121.0});
  const CrankCurrent crank = findCrankCurrent(series);
  EXPECT_EQ(crank.source, CrankCurrent::Source::kRecording);
  EXPECT_DOUBLE_EQ(crank.current, -72.0);
  EXPECT_EQ(cranksIn(series, crank), 4u);
  EXPECT_EQ(cranksIn(series, {}), 0u);
}

TEST(CrankCurrent, OfALargeEngineIsThePapers) {
  const Series series = driveWith({-400.0, -380.0, -250.0, -120.0});
  const CrankCurrent crank = findCrankCurrent(series);
  EXPECT_DOUBLE_EQ(crank.current, kCrankCurrent);
  EXPECT_EQ(cranksIn(series, crank), 3u);
  EXPECT_EQ(crank.source, CrankCurrent::Source::kUsual);
  EXPECT_DOUBLE_EQ(crank.pulse.value(), -250.0);
  EXPECT_DOUBLE_EQ(findCrankCurrent(driveWith({-220.0, -140.0})).current, kCrankCurrent)
      << "a slow sampling shows a large engine's starts at any depth";
}

TEST(CrankCurrent, OfASmallEngineStaysSoWhereSomeOfItsStartsReachThePapers) {
  EXPECT_DOUBLE_EQ(
      findCrankCurrent(driveWith({-160.0, -155.0, -151.0, -130.0, -128.0, -120.0, -125.0})).current,
      -91.0);
}

TEST(CrankCurrent, IsReadOffASinglePulseToo) {
  const CrankCurrent crank = findCrankCurrent(driveWith({-110.0}));
  EXPECT_EQ(crank.source, CrankCurrent::Source::kRecording);
  EXPECT_DOUBLE_EQ(crank.current, -66.0);
}

TEST(CrankCurrent, DoesNotFollowOneOutlier) {
  EXPECT_DOUBLE_EQ(findCrankCurrent(driveWith({-240.0, -120.0, -118.0, -121.0})).current, -72.0);
}

TEST(CrankCurrent, IsTheUsualWhereNothingStandsClearOfTheLoad) {
  EXPECT_EQ(findCrankCurrent(driveWith({})).source, CrankCurrent::Source::kUsual);
  EXPECT_EQ(findCrankCurrent(driveWith({-50.0, -50.0, -50.0})).source,
            CrankCurrent::Source::kUsual);
  EXPECT_EQ(findCrankCurrent(driveWith({-110.0, -110.0}, 0.02, -60.0)).source,
            CrankCurrent::Source::kUsual);
  EXPECT_EQ(findCrankCurrent(driveWith({-120.0, -120.0, -120.0}, 0.002)).source,
            CrankCurrent::Source::kUsual)
      << "the voltage does not answer as to a starter";
  EXPECT_EQ(findCrankCurrent({}).current, kCrankCurrent);
}

TEST(CrankCurrent, IsTheUsualWherePulsesFallBetweenSamples) {
  Series series;
  for (int k = 0; k < 100; ++k)
    series.append({60.0 * k, k % 10 == 5 ? -120.0 : -2.0, k % 10 == 5 ? 10.0 : 12.5});
  EXPECT_EQ(findCrankCurrent(series).source, CrankCurrent::Source::kUsual);
}

/// The whole and its eighths.
TEST(CrankCurrent, OfStartStopCarsFindsTheCranksOfThePapers) {
  const std::filesystem::path folder = BATTERY_SOF_SOURCE_DIR "/../shared/data";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no recordings in ../shared/data";
  for (const char* file :
       {"startstop_car/drive_1.csv", "startstop_car/drive_2.csv", "small_car/trip.csv"}) {
    const Series whole = readCsv(folder / file).series;
    for (std::size_t part = 0; part <= 8; ++part) {
      const std::size_t size = whole.size();
      const Series series =
          slice(whole, part == 8 ? IndexRange{0, size}
                                 : IndexRange{part * size / 8, (part + 1) * size / 8});
      EXPECT_EQ(cranksIn(series, findCrankCurrent(series)), cranksIn(series, {}))
          << file << ", part " << part;
    }
  }
}

TEST(CrankCurrent, ThatIsGivenIsTaken) {
  const CrankCurrent crank = crankCurrentOf(driveWith({-120.0, -120.0, -120.0}), -40.0);
  EXPECT_EQ(crank.source, CrankCurrent::Source::kGiven);
  EXPECT_DOUBLE_EQ(crank.current, -40.0);
  for (const double wrong : {0.0, 40.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(crankCurrentOf({}, wrong), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof
