#include "diagnosis/screening.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

/// A sample a second whose voltage is two seconds late, with a pause: what is found of the pause
/// stands behind what is found of the shift.
Recording lateWithAPause() {
  constexpr std::size_t kSecond = 100, kLate = 200;  // samples at 100 Hz
  const Series fast = test::baseDrive(3, 1200.0);
  Recording recording;
  recording.name = "logger";
  for (std::size_t k = kLate; k < fast.size(); k += kSecond)
    recording.series.append({fast.time[k] + (k > fast.size() / 2 ? 600.0 : 0.0), fast.current[k],
                             fast.voltage[k - kLate]});
  recording.offered = recording.series.size();
  return recording;
}

std::ptrdiff_t sentencesOf(const Screening& screening, const std::string& beginning) {
  return std::count_if(screening.sentences.begin(), screening.sentences.end(),
                       [&](const std::string& one) { return one.rfind(beginning, 0) == 0; });
}

TEST(ScreenInstruments, MovesTheCurrentOnceWhateverElseIsFound) {
  const Recording recording = lateWithAPause();
  const Screening screening = screenInstruments(recording, recording.series);
  ASSERT_TRUE(screening.skew);
  EXPECT_GT(screening.late_samples, 0);
  EXPECT_EQ(sentencesOf(screening, "1 gap"), 1);
  EXPECT_EQ(sentencesOf(screening, "the current was shifted by "), 1);
}

}  // namespace
}  // namespace battery_sof
