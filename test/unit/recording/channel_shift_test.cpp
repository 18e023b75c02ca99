#include "recording/channel_shift.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace battery_sof {
namespace {

/// A current of 1 A a second, at 10 Hz; the voltage is ten times the time.
Series ramp() {
  Series series;
  for (int n = 0; n <= 100; ++n) series.append({0.1 * n, 0.1 * n, n * 1.0});
  return series;
}

TEST(ShiftedCurrent, IsWhatWasMeasuredSoMuchEarlierWhereTheShiftIsPositive) {
  for (const double shift : {0.25, -0.25, 1.0, -0.047}) {
    const Series moved = withShiftedCurrent(ramp(), shift);
    ASSERT_GT(moved.size(), 85u);
    for (std::size_t n = 0; n < moved.size(); ++n) {
      EXPECT_NEAR(moved.current[n], moved.time[n] - shift, 1e-9);
      EXPECT_NEAR(moved.voltage[n], 10.0 * moved.time[n], 1e-9);
    }
  }
}

TEST(ShiftedCurrent, InventsNoCurrentAtTheEndsOrInAGap) {
  EXPECT_NEAR(withShiftedCurrent(ramp(), 2.0).time.front(), 2.0, 0.11);
  EXPECT_NEAR(withShiftedCurrent(ramp(), -2.0).time.back(), 8.0, 0.11);
  EXPECT_TRUE(withShiftedCurrent(ramp(), 20.0).empty());
  Series gap = ramp();
  for (std::size_t n = 50; n < gap.size(); ++n) gap.time[n] += 100.0;
  const Series moved = withShiftedCurrent(gap, 0.5);
  for (std::size_t n = 0; n < moved.size(); ++n)
    EXPECT_TRUE(moved.time[n] < 5.0 || moved.time[n] > 105.4) << moved.time[n];
}

TEST(ShiftedCurrent, KeepsTemperaturesAndRefusesWhatIsNoTime) {
  Series series = ramp();
  series.temperature_time = {1.0};
  series.temperature = {298.0};
  EXPECT_EQ(withShiftedCurrent(series, 0.2).temperature, series.temperature);
  EXPECT_THROW(withShiftedCurrent(series, std::nan("")), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof
