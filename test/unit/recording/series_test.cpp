#include "battery_sof/series.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "battery_sof/model.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

Series seriesAt(const std::vector<double>& time) {
  Series series;
  series.time = time;
  series.current.assign(time.size(), -1.0);
  for (std::size_t k = 0; k < time.size(); ++k) series.voltage.push_back(12.0 + 0.1 * k);
  return series;
}

std::string complaintAbout(const Series& series) {
  try {
    requireInvariants(series);
  } catch (const std::invalid_argument& refusal) {
    return refusal.what();
  }
  return "";
}

TEST(Invariants, HoldForASoundSeriesAndAnEmptyOne) {
  EXPECT_EQ(complaintAbout(seriesAt({0.0, 1.0, 5.0})), "");
  EXPECT_EQ(complaintAbout(Series()), "");
}

TEST(Invariants, AreSaidToBeBrokenByASampleThatIsNotLaterThanTheOneBefore) {
  EXPECT_EQ(complaintAbout(seriesAt({0.0, 1.0, 1.0, 2.0})),
            "series: time of sample 2 is 1 s, expected more than the 1 s before it");
  EXPECT_NE(complaintAbout(seriesAt({0.0, 2.0, 1.0})), "");
}

TEST(Invariants, AreSaidToBeBrokenByAChannelThatIsTooShortOrNotFinite) {
  Series series = seriesAt({0.0, 1.0, 2.0});
  series.current[1] = std::nan("");
  EXPECT_EQ(complaintAbout(series), "series: current of sample 1 is nan, expected a finite number");
  series.current.pop_back();
  EXPECT_EQ(complaintAbout(series),
            "series: 3 times, 2 currents and 3 voltages, expected as many of each");
}

// Without this check a clock that steps back ends in memory that is not there.
TEST(Invariants, AreLookedAtBeforeARecordingOfACallerIsFittedOrDiagnosed) {
  Recording recording;
  recording.series = seriesAt({0.0, 1.0, 1.0, 2.0});
  EXPECT_THROW(identify(recording), std::invalid_argument);
  EXPECT_THROW(diagnose(recording, DiagnosisRequest()), std::invalid_argument);
}

TEST(MedianInterval, IsTheMiddleOneOfAnOddCount) {
  EXPECT_DOUBLE_EQ(medianInterval(seriesAt({0.0, 1.0, 3.0, 100.0})), 2.0);
}

TEST(MedianInterval, IsTheMeanOfTheTwoMiddleOnesOfAnEvenCount) {
  EXPECT_DOUBLE_EQ(medianInterval(seriesAt({0.0, 1.0, 4.0, 6.0, 100.0})), 2.5);
}

TEST(MedianInterval, IsThatOfSortedIntervalsHoweverManyOfThemAreEqual) {
  test::Random random(3);
  for (const double jitter : {0.0, 1e-13, 0.004})
    for (const std::size_t count : {2U, 3U, 300U, 1001U, 2000U}) {
      std::vector<double> time, intervals;
      for (std::size_t k = 0; k < count; ++k)
        time.push_back(100.0 + 0.01 * static_cast<double>(k) + jitter * random.uniform(0.0, 1.0));
      for (std::size_t k = 1; k < count; ++k) intervals.push_back(time[k] - time[k - 1]);
      std::sort(intervals.begin(), intervals.end());
      const std::size_t n = intervals.size();
      EXPECT_DOUBLE_EQ(medianInterval(seriesAt(time)),
                       0.5 * (intervals[(n - 1) / 2] + intervals[n / 2]));
    }
}

TEST(MedianInterval, OfARangeIsThatOfItsSlice) {
  const Series series = seriesAt({0.0, 1.0, 3.0, 7.0, 15.0, 31.0, 32.0});
  for (std::size_t first = 0; first < series.size(); ++first)
    for (std::size_t last = first; last <= series.size(); ++last)
      EXPECT_EQ(medianInterval(series.time, {first, last}),
                medianInterval(slice(series, {first, last})));
  EXPECT_EQ(gapThreshold(medianInterval(series)), gapThreshold(series));
}

TEST(MedianInterval, IsZeroForFewerThanTwoSamples) {
  EXPECT_EQ(medianInterval(Series()), 0.0);
  EXPECT_EQ(medianInterval(seriesAt({7.0})), 0.0);
}

TEST(GapThreshold, IsTenIntervalsButAtLeastFiveSeconds) {
  EXPECT_DOUBLE_EQ(gapThreshold(seriesAt({0.0, 0.01, 0.02})), 5.0);
  EXPECT_DOUBLE_EQ(gapThreshold(seriesAt({0.0, 60.0, 120.0})), 600.0);
}

TEST(ContiguousRanges, AreCutWhereTheIntervalExceedsTheGap) {
  const auto ranges = contiguousRanges(seriesAt({0.0, 1.0, 2.0, 8.0, 9.0, 20.0}), 5.0);
  ASSERT_EQ(ranges.size(), 3U);
  EXPECT_EQ(ranges[0].first, 0U);
  EXPECT_EQ(ranges[0].last, 3U);
  EXPECT_EQ(ranges[1].first, 3U);
  EXPECT_EQ(ranges[1].last, 5U);
  EXPECT_EQ(ranges[2].size(), 1U);
}

TEST(ContiguousRanges, AnIntervalOfExactlyTheGapIsJoined) {
  EXPECT_EQ(contiguousRanges(seriesAt({0.0, 5.0}), 5.0).size(), 1U);
}

TEST(ContiguousRanges, AnEmptySeriesHasNone) { EXPECT_TRUE(contiguousRanges({}, 5.0).empty()); }

TEST(IndexRangeOfTimes, IncludesBothEnds) {
  const IndexRange range = indexRange(seriesAt({0.0, 1.0, 2.0, 3.0}), 1.0, 2.0);
  EXPECT_EQ(range.first, 1U);
  EXPECT_EQ(range.last, 3U);
}

TEST(IndexRangeOfTimes, IsEmptyBetweenSamplesOutsideTheSeriesAndForReversedEnds) {
  const Series series = seriesAt({0.0, 1.0, 2.0});
  EXPECT_TRUE(indexRange(series, 0.2, 0.8).empty());
  EXPECT_TRUE(indexRange(series, 5.0, 9.0).empty());
  EXPECT_TRUE(indexRange(series, 2.0, 0.0).empty());
}

TEST(Slice, CopiesTheSamplesAndTheTemperaturesBetweenThem) {
  Series series = seriesAt({0.0, 1.0, 2.0, 3.0});
  series.temperature_time = {0.5, 1.5, 2.5};
  series.temperature = {290.0, 291.0, 292.0};
  const Series part = slice(series, {1, 3});
  EXPECT_EQ(part.time, (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(part.voltage, (std::vector<double>{12.1, 12.2}));
  EXPECT_EQ(part.current.size(), 2U);
  EXPECT_EQ(part.temperature_time, (std::vector<double>{1.5}));
  EXPECT_EQ(part.temperature, (std::vector<double>{291.0}));
}

TEST(Slice, OfAnEmptyRangeIsEmpty) { EXPECT_TRUE(slice(seriesAt({0.0, 1.0}), {1, 1}).empty()); }

TEST(TemperatureAt, InterpolatesAndHoldsTheEnds) {
  Series series;
  series.temperature_time = {10.0, 20.0};
  series.temperature = {290.0, 300.0};
  EXPECT_DOUBLE_EQ(*temperatureAt(series, 15.0), 295.0);
  EXPECT_DOUBLE_EQ(*temperatureAt(series, 10.0), 290.0);
  EXPECT_DOUBLE_EQ(*temperatureAt(series, 0.0), 290.0);
  EXPECT_DOUBLE_EQ(*temperatureAt(series, 99.0), 300.0);
}

TEST(TemperatureAt, IsNothingWhenNotMeasured) {
  EXPECT_FALSE(temperatureAt(seriesAt({0.0, 1.0}), 0.5).has_value());
}

}  // namespace
}  // namespace battery_sof
