#include <gtest/gtest.h>

#include <filesystem>

#include "support/drive_in_folder.hpp"

namespace battery_sof {
namespace {

using test::Outcome;
using test::sof;

using WithoutRos = test::DriveInFolder;

TEST_F(WithoutRos, ABagIsNotReadAndTheReasonIsSaid) {
  expectRefused(write("drive.bag", "#ROSBAG V2.0\n"),
                {"drive.bag", "battery_state", "has no ROS", "expected a CSV file"});
}

TEST_F(WithoutRos, ABagUnderAnotherNameIsKnownByItsFirstBytes) {
  expectRefused(write("drive.csv", "#ROSBAG V2.0\n"), {"drive.csv", "has no ROS"});
}

TEST_F(WithoutRos, ABagIsNotWrittenAndTheReasonIsSaid) {
  const Outcome outcome = sof({"convert", inputs_, path("out.bag"), "--topic", "starter"});
  EXPECT_EQ(outcome.code, 2);
  for (const char* piece : {"out.bag", "starter", "has no ROS", "expected a name ending in .csv"})
    EXPECT_NE(outcome.err.find(piece), std::string::npos) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(path("out.bag")));
}

}  // namespace
}  // namespace battery_sof
