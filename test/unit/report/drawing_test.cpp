#include "report/drawing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

Series longDrive() { return test::baseDrive(3, 600.0); }  // 60,000 samples

TEST(DisplaySamples, KeepEverySampleOfAShortSeries) {
  const Series series = test::baseDrive(3, 10.0);
  const auto shown =
      displaySamples(series, {[&](std::size_t n) { return series.voltage[n]; }}, 1000);
  EXPECT_EQ(shown.size(), series.size());
  EXPECT_TRUE(displaySamples({}, {}, 1000).empty());
}

TEST(DisplaySamples, KeepTheExtremesOfEveryTraceInEveryBucket) {
  const Series series = longDrive();
  const Trace voltage = [&](std::size_t n) { return series.voltage[n]; };
  const Trace current = [&](std::size_t n) { return series.current[n]; };
  const auto shown = displaySamples(series, {voltage, current}, 100);
  EXPECT_LE(shown.size(), 100u * 5u + 1u);
  for (const Trace& trace : {voltage, current})
    for (std::size_t bucket = 0; bucket < 100; ++bucket) {
      const double width = (series.time.back() - series.time.front()) / 100.0;
      double low = 1e9, low_shown = 1e9;
      for (std::size_t n = 0; n < series.size(); ++n)
        if (std::floor((series.time[n] - series.time.front()) / width) ==
            static_cast<double>(bucket))
          low = std::min(low, trace(n));
      for (const std::size_t n : shown)
        if (std::floor((series.time[n] - series.time.front()) / width) ==
            static_cast<double>(bucket))
          low_shown = std::min(low_shown, trace(n));
      EXPECT_EQ(low, low_shown);
    }
}

TEST(DisplaySamples, AreInOrderWithoutRepeatsFromFirstToLast) {
  const Series series = longDrive();
  const auto shown = displaySamples(series, {[&](std::size_t n) { return series.voltage[n]; }}, 50,
                                    {{1000, 1100}});
  EXPECT_EQ(std::adjacent_find(shown.begin(), shown.end(), std::greater_equal<>()), shown.end());
  EXPECT_EQ(shown.front(), 0u);
  EXPECT_EQ(shown.back(), series.size() - 1);
  EXPECT_EQ(std::count_if(shown.begin(), shown.end(),
                          [](std::size_t n) { return n >= 1000 && n < 1100; }),
            100);
}

TEST(DisplaySamples, SpendNothingOnAGap) {
  Series series = longDrive();
  for (std::size_t n = series.size() / 2; n < series.size(); ++n) series.time[n] += 1e6;
  const auto shown =
      displaySamples(series, {[&](std::size_t n) { return series.voltage[n]; }}, 100);
  EXPECT_LE(shown.size(), 8u);
}

}  // namespace
}  // namespace battery_sof
