#include "battery_sof/sample_list.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace battery_sof {
namespace {

std::string errorOf(const std::vector<RawSample>& samples) {
  try {
    recordingOf("arrays", samples);
  } catch (const RecordingError& error) {
    return error.what();
  }
  return "";
}

TEST(RecordingOf, JudgesSamplesAsThoseOfAFile) {
  const Recording recording = recordingOf("arrays", {{0.0, -5.0, 12.5, 293.15},
                                                     {1.0, std::nan(""), 12.5, {}},
                                                     {2.0, 9000.0, 12.5, {}},
                                                     {2.0, 1.0, 12.5, {}}});
  EXPECT_EQ(recording.name, "arrays");
  EXPECT_EQ(recording.series.time, (std::vector<double>{0.0, 2.0}));
  EXPECT_EQ(recording.series.temperature, (std::vector<double>{293.15}));
  EXPECT_EQ(recording.offered, 4u);
  EXPECT_EQ(recording.rejected.missing_value, 1u);
  EXPECT_EQ(recording.rejected.out_of_range, 1u);
}

TEST(RecordingOf, RefusesWhatIsNoRecordingAndSaysWhy) {
  EXPECT_EQ(errorOf({}), "arrays: has no sample, expected at least one");
  EXPECT_EQ(errorOf({{2.0, 1.0, 12.0, {}}, {1.0, 1.0, 12.0, {}}}),
            "arrays: is not sorted by time: 1 of 2 samples go back in time");
  EXPECT_EQ(
      errorOf({{1.0, std::nan(""), 12.0, {}}}),
      "arrays: holds no usable sample: of 1, 1 lack a value, 0 are not finite, 0 are out of range");
}

}  // namespace
}  // namespace battery_sof
