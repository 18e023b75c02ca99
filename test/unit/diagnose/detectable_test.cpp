#include "battery_sof/diagnose/detectable.hpp"

#include <gtest/gtest.h>

#include "support/null_fits.hpp"

namespace battery_sof {
namespace {

const Drive& tenMinutes() {
  static const Drive drive = [] {
    const Series series = test::baseDrive(5, 600.0, 0.0);
    return compressedDrive(series, {0, series.size()});
  }();
  return drive;
}

Detectable ofSlope(double noise, DiagnosisThresholds thresholds = {}) {
  static const test::NullFits fits(tenMinutes());
  const WhitenedFit fit = fits.of(test::drawnNoise({noise, noise, 10.0, 1e-5}, tenMinutes(), 3));
  return detectableBeside(fit, tenMinutes(), screen(fit, tenMinutes(), {"ocv_soc"}, 1), thresholds).front();
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

TEST(Detectable, AUsualStrengthIsVisibleWhereItIsLargerThanTheLeast) {
  const Detectable one = ofSlope(1e-4);
  EXPECT_EQ("ocv_slope", one.parameter);
  EXPECT_EQ(one.visible, one.strength <= one.typical);
  EXPECT_TRUE(one.visible);
  EXPECT_FALSE(ofSlope(0.1).visible);
}

}  // namespace
}  // namespace battery_sof
