#include "battery_sof/intake.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace battery_sof {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

RawSample at(double time, double current = -5.0, double voltage = 12.4) {
  return {time, current, voltage, std::nullopt};
}

TEST(Intake, SampleLaterThanTheLastIsAccepted) {
  Intake intake;
  EXPECT_EQ(intake.judge(at(0.0)), SampleFate::kAccepted);
  EXPECT_EQ(intake.judge(at(0.01)), SampleFate::kAccepted);
  EXPECT_EQ(intake.rejected().total(), 0U);
}

TEST(Intake, SampleWithTheSameStampIsRefusedAndCounted) {
  Intake intake;
  intake.judge(at(1.0));
  EXPECT_EQ(intake.judge(at(1.0)), SampleFate::kDuplicateStamp);
  EXPECT_EQ(intake.rejected().duplicate_stamp, 1U);
  EXPECT_EQ(intake.largestStepBack(), 0.0);
}

TEST(Intake, SampleBehindAClockStepBackIsRefusedUntilTheClockHasCaughtUp) {
  Intake intake;
  intake.judge(at(10.0));
  EXPECT_EQ(intake.judge(at(7.0)), SampleFate::kClockStepBack);
  EXPECT_EQ(intake.judge(at(8.0)), SampleFate::kClockStepBack);
  EXPECT_EQ(intake.judge(at(11.0)), SampleFate::kAccepted);
  EXPECT_EQ(intake.rejected().clock_step_back, 2U);
  EXPECT_DOUBLE_EQ(intake.largestStepBack(), 3.0);
}

TEST(Intake, SampleWithoutTimeCurrentOrVoltageIsAMissingValue) {
  Intake intake;
  EXPECT_EQ(intake.judge(at(kNaN)), SampleFate::kMissingValue);
  EXPECT_EQ(intake.judge(at(0.0, kNaN)), SampleFate::kMissingValue);
  EXPECT_EQ(intake.judge(at(0.0, -5.0, kNaN)), SampleFate::kMissingValue);
  EXPECT_EQ(intake.judge(at(0.0, kNaN, kNaN)), SampleFate::kMissingValue);
  EXPECT_EQ(intake.rejected().missing_value, 4U);
}

TEST(Intake, InfiniteTimeCurrentOrVoltageIsRefused) {
  Intake intake;
  EXPECT_EQ(intake.judge(at(kInfinity)), SampleFate::kNotFinite);
  EXPECT_EQ(intake.judge(at(0.0, -kInfinity)), SampleFate::kNotFinite);
  EXPECT_EQ(intake.judge(at(0.0, -5.0, kInfinity)), SampleFate::kNotFinite);
  EXPECT_EQ(intake.rejected().not_finite, 3U);
}

TEST(Intake, ValueBeyondTheLimitsIsOutOfRangeAndOneAtThemIsNot) {
  Intake intake;
  EXPECT_EQ(intake.judge(at(0.0, -5001.0)), SampleFate::kOutOfRange);
  EXPECT_EQ(intake.judge(at(0.0, -5.0, 100.1)), SampleFate::kOutOfRange);
  EXPECT_EQ(intake.judge(at(0.0, 5000.0, -100.0)), SampleFate::kAccepted);
  EXPECT_EQ(intake.rejected().out_of_range, 2U);
}

TEST(Intake, RefusedSampleDoesNotMoveTheClock) {
  Intake intake;
  intake.judge(at(1.0));
  intake.judge(at(50.0, kNaN));
  EXPECT_EQ(intake.judge(at(2.0)), SampleFate::kAccepted);
}

TEST(Intake, TemperatureAloneIsKeptOnItsOwnClock) {
  Intake intake;
  intake.judge(at(10.0));
  const RawSample warm{5.0, kNaN, kNaN, 298.0};
  EXPECT_EQ(intake.judge(warm), SampleFate::kTemperatureOnly);
  EXPECT_EQ(intake.judge(warm), SampleFate::kDuplicateStamp);
  EXPECT_EQ(intake.judge(at(11.0)), SampleFate::kAccepted);
}

TEST(Intake, ForgettingTheClockAcceptsAnEarlierStampAndKeepsTheCounts) {
  Intake intake;
  intake.judge(at(10.0));
  intake.judge(at(9.0));
  intake.forgetClock();
  EXPECT_EQ(intake.judge(at(1.0)), SampleFate::kAccepted);
  EXPECT_EQ(intake.rejected().clock_step_back, 1U);
}

TEST(Append, AcceptedSamplesAndTheirTemperaturesEnterTheSeriesOthersAreCounted) {
  Recording recording;
  Intake intake;
  append(recording, intake, {0.0, -5.0, 12.4, 298.15});
  append(recording, intake, at(0.0));
  append(recording, intake, at(1.0, kNaN));
  append(recording, intake, {2.0, kNaN, kNaN, 299.15});
  append(recording, intake, at(3.0, -6.0, 12.3));
  EXPECT_EQ(recording.series.time, (std::vector<double>{0.0, 3.0}));
  EXPECT_EQ(recording.series.current, (std::vector<double>{-5.0, -6.0}));
  EXPECT_EQ(recording.series.voltage, (std::vector<double>{12.4, 12.3}));
  EXPECT_EQ(recording.series.temperature_time, (std::vector<double>{0.0, 2.0}));
  EXPECT_EQ(recording.series.temperature, (std::vector<double>{298.15, 299.15}));
  EXPECT_EQ(recording.offered, 4U);
  EXPECT_EQ(recording.offered, recording.series.size() + recording.rejected.total());
}

TEST(Append, TimeBehindTheRecordingIsTheCallersErrorAfterTheClockWasForgotten) {
  Recording recording;
  Intake intake;
  append(recording, intake, at(10.0));
  intake.forgetClock();
  EXPECT_THROW(append(recording, intake, at(1.0)), std::invalid_argument);
  EXPECT_EQ(recording.series.size(), 1U);
}

TEST(Intake, StampsNearerThanATenthOfAMicrosecondAreOneInstant) {
  Intake intake;
  intake.judge(at(1.0));
  EXPECT_EQ(intake.judge(at(1.0 + 1e-12)), SampleFate::kDuplicateStamp);
  EXPECT_EQ(intake.judge(at(1.0 + 0.9e-7)), SampleFate::kDuplicateStamp);
  EXPECT_EQ(intake.judge(at(1.0 + 1e-6)), SampleFate::kAccepted);
  EXPECT_EQ(intake.rejected().duplicate_stamp, 2U);
}

TEST(Intake, ATemperatureThatNoneCanBeIsLeftOutAndCountedAndItsSampleIsTaken) {
  Recording recording;
  Intake intake;
  double time = 0.0;
  for (const double celsius : {25.0, 1e9, -273.15, 151.0, -61.0, -59.0, 149.0})
    EXPECT_EQ(append(recording, intake, {time += 1.0, -5.0, 12.5, celsius + 273.15}),
              SampleFate::kAccepted);
  append(recording, intake, {time += 1.0, -5.0, 12.5, kNaN});
  append(recording, intake, {time += 1.0, -5.0, 12.5, std::numeric_limits<double>::infinity()});
  EXPECT_EQ(recording.series.size(), 9U);
  EXPECT_EQ(recording.series.temperature.size(), 3U);
  EXPECT_EQ(intake.rejectedTemperatures(), 5U);
  EXPECT_EQ(intake.rejected().total(), 0U);
}

TEST(Intake, ATemperatureAloneThatNoneCanBeIsLeftOutAndCounted) {
  Recording recording;
  Intake intake;
  append(recording, intake, {1.0, kNaN, kNaN, 1e9});
  EXPECT_TRUE(recording.series.temperature.empty());
  EXPECT_EQ(intake.rejectedTemperatures(), 1U);
}

TEST(Intake, StampThatIsNoTimeInSecondsIsOutOfRange) {
  Intake intake;
  EXPECT_EQ(intake.judge(at(1e15)), SampleFate::kOutOfRange);
  EXPECT_EQ(intake.judge(at(-1e11)), SampleFate::kOutOfRange);
  EXPECT_EQ(intake.judge({1e15, kNaN, kNaN, 298.0}), SampleFate::kOutOfRange);
  EXPECT_EQ(intake.judge(at(4294967294.0)), SampleFate::kAccepted) << "the last stamp ROS can hold";
  EXPECT_EQ(intake.rejected().out_of_range, 3U);
}

}  // namespace
}  // namespace battery_sof
