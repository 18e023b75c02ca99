#include "ros/node_statistics.hpp"

#include <gtest/gtest.h>

namespace battery_sof {
namespace {

TEST(ResponseClock, ReportsThe99thPercentileAndTheLongest) {
  ResponseClock clock;
  for (int n = 1; n <= 1000; ++n) clock.addQuery(n);
  const ResponseTimes times = clock.report();
  EXPECT_EQ(times.queries, 1000u);
  EXPECT_NEAR(times.query_p99_ms, 990.0, 1.0);
  EXPECT_EQ(times.query_longest_ms, 1000.0);
  EXPECT_EQ(times.sample_p99_ms, 0.0);
}

TEST(ResponseClock, ForgetsWhatIsLongPast) {
  ResponseClock clock;
  clock.addQuery(1e6);
  for (std::size_t n = 0; n < ResponseClock::kKept; ++n) clock.addQuery(1.0);
  EXPECT_EQ(clock.report().query_longest_ms, 1.0);
  EXPECT_EQ(clock.report().queries, ResponseClock::kKept + 1);
}

TEST(ResponseClock, TheLongestSampleIsThatSinceTheReportBefore) {
  ResponseClock clock;
  clock.addSample(7.0);
  clock.addSample(3.0);
  EXPECT_EQ(clock.report().sample_longest_ms, 7.0);
  EXPECT_EQ(clock.report().sample_longest_ms, 0.0);
}

}  // namespace
}  // namespace battery_sof
