#include "battery_sof/diagnose/detectable.hpp"

#include <gtest/gtest.h>

#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

/// Ten minutes of the base model, fitted.
struct Fitted {
  Drive drive;
  WhitenedFit fit;
};

Fitted fittedWith(double noise) {
  const Series series = test::baseDrive(5, 600.0, noise);
  const Drive drive = compressedDrive(series, {0, series.size()});
  const BatteryModel model;
  return {drive, fitWhitened(model, drive, {typicalStart(model, drive)}, std::nullopt)};
}

Detectable ofSlope(double noise, DiagnosisThresholds thresholds = {}) {
  const Fitted fitted = fittedWith(noise);
  return detectableBeside(fitted.fit, fitted.drive, screen(fitted.fit, fitted.drive, {"ocv_soc"}, 1), thresholds, 1).front();
}

TEST(Detectable, TenTimesTheNoiseTakesTenTimesTheStrength) {
  EXPECT_NEAR(10.0, ofSlope(0.02).strength / ofSlope(0.002).strength, 1.0);
}

TEST(Detectable, WhatANameMustTakeOutOfTheErrorCounts) {
  DiagnosisThresholds strict;
  strict.least_share = 0.5;  // the error must fall by half: the effect must be sqrt(3) times what is left
  DiagnosisThresholds stricter;
  stricter.least_share = 0.75;  // sqrt(15) times
  EXPECT_NEAR(std::sqrt(5.0), ofSlope(0.002, stricter).strength / ofSlope(0.002, strict).strength, 1e-6);
}

TEST(Detectable, WhatIsLeftAndStrongerWouldBeTakenFirst) {
  const Fitted fitted = fittedWith(0.002);
  DiagnosisThresholds by_evidence;
  by_evidence.least_share = 1e-6;
  std::vector<Signature> screened = screen(fitted.fit, fitted.drive, {"ocv_soc", "cpe2"}, 1);
  screened[1].score = 900.0;
  const double once = detectableBeside(fitted.fit, fitted.drive, screened, by_evidence, 1).front().strength;
  screened[1].score = 3600.0;
  EXPECT_NEAR(2.0, detectableBeside(fitted.fit, fitted.drive, screened, by_evidence, 1).front().strength / once, 1e-6);
}

TEST(Detectable, AUsualStrengthIsVisibleWhereItIsLargerThanTheLeast) {
  const Detectable one = ofSlope(1e-4);
  EXPECT_EQ("ocv_slope", one.parameter);
  EXPECT_EQ(one.visible, one.strength <= one.typical);
  EXPECT_TRUE(one.visible);
  EXPECT_FALSE(ofSlope(0.1).visible);
}

}  // namespace
}  // namespace battery_sof
