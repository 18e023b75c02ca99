#include "cli/progress.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace battery_sof {
namespace {

TEST(Pace, SaysTheTimeLeftOnceAShareOfTheStageIsDone) {
  EXPECT_EQ(pace(12.4, 10.0, std::nullopt), "12 s");
  EXPECT_EQ(pace(12.4, 10.0, 0.25), "12 s, about 30 s left");
  EXPECT_EQ(pace(12.4, 10.0, 1.0), "12 s, about 0 s left");
  EXPECT_EQ(pace(12.4, 10.0, 0.001), "12 s") << "too early to tell";
}

TEST(Progress, SaysNothingOfShortWork) {
  std::ostringstream err;
  Progress progress(err);
  progress.stage("checking");
  progress.done(0.5);
  progress.hide();
  progress.end();
  progress.end();
  EXPECT_EQ(err.str(), "");
}

}  // namespace
}  // namespace battery_sof
