#include "recording/deep_discharge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recording/checks.hpp"

namespace battery_sof {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::Not;

/// A sample a second, each of a current and a voltage.
struct Stream {
  Series series;
  Stream& hold(double seconds, double current, double voltage) {
    for (int n = 0; n < static_cast<int>(seconds); ++n)
      series.append({static_cast<double>(series.size()), current, voltage});
    return *this;
  }
};

TEST(DeepDischarge, ABatteryRunDownByASmallLoadIsFoundWithTimeAndLowestVoltage) {
  Stream stream;
  stream.hold(100, -2.0, 12.0);
  for (double voltage = 12.0; voltage > 9.0; voltage -= 0.01) stream.hold(1, -2.0, voltage);
  const DeepDischargeDetector found = findDeepDischarges(stream.series);
  ASSERT_EQ(found.count(), 1u);
  EXPECT_NEAR(found.first()->from, 100.0 + 151.0, 1.5);
  EXPECT_NEAR(found.deepest()->lowest, 9.0, 0.02);
  EXPECT_EQ(found.deepest()->to, stream.series.time.back());
  EXPECT_THAT(found.toString(1.0), HasSubstr("the battery was discharged below 10.5 V at 251 s"));
  EXPECT_THAT(found.toString(2.0), HasSubstr("below 21 V"));
}

TEST(DeepDischarge, ACrankIsNone) {
  Stream stream;
  for (int n = 0; n < 50; ++n) {
    stream.hold(20, -10.0, 12.3).hold(8, -300.0, 8.0);
    stream.hold(2, -10.0, 8.0);  // a voltage that comes two samples late
  }
  const DeepDischargeDetector found = findDeepDischarges(stream.series);
  EXPECT_EQ(found.count(), 0u);
  EXPECT_EQ(found.toString(1.0), "");
}

TEST(DeepDischarge, WhatHoldsTheVoltageDownForAMinuteIsOneWhateverFlows) {
  Stream stream;
  stream.hold(20, -10.0, 12.3).hold(62, -60.0, 10.2);
  EXPECT_EQ(findDeepDischarges(stream.series).count(), 1u);
  Stream brief;
  brief.hold(20, -10.0, 12.3).hold(58, -60.0, 10.2).hold(20, -10.0, 12.0);
  EXPECT_EQ(findDeepDischarges(brief.series).count(), 0u);
}

TEST(DeepDischarge, SeveralAreCountedAndTheDeepestIsKept) {
  Stream stream;
  stream.hold(60, -5.0, 12.0).hold(30, -5.0, 10.0).hold(60, 20.0, 12.0).hold(40, -5.0, 9.5);
  stream.hold(60, 20.0, 12.5).hold(30, -5.0, 10.3);
  const DeepDischargeDetector found = findDeepDischarges(stream.series);
  EXPECT_EQ(found.count(), 3u);
  EXPECT_EQ(found.first()->from, 60.0);
  EXPECT_EQ(found.deepest()->lowest, 9.5);
  EXPECT_NEAR(found.duration(), 29.0 + 39.0 + 29.0, 1e-9);
}

TEST(DeepDischarge, AGapEndsWhatIsUnderWay) {
  Series series;
  for (int n = 0; n < 8; ++n) series.append({n + 0.0, -2.0, 10.0});
  for (int n = 0; n < 8; ++n) series.append({n + 1000.0, -2.0, 10.0});
  EXPECT_EQ(findDeepDischarges(series).count(), 0u);
}

TEST(DeepDischarge, CheckReportsIt) {
  Recording recording;
  Stream stream;
  for (int n = 0; n < 20; ++n) stream.hold(20, -5.0 - 0.1 * n, 12.0 - 0.01 * n);
  recording.series = stream.hold(60, -5.0, 9.2).series;
  EXPECT_THAT(checkRecording(recording).findings, Contains(Field(&Finding::id, "deep_discharge")));
  recording.series = Stream().hold(200, -5.0, 12.0).hold(200, 5.0, 13.0).series;
  EXPECT_THAT(checkRecording(recording).findings,
              Not(Contains(Field(&Finding::id, "deep_discharge"))));
}

}  // namespace
}  // namespace battery_sof
