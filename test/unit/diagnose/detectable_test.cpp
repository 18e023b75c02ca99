#include "battery_sof/diagnose/detectable.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

NameRule by(const DiagnosisThresholds& thresholds) { return {thresholds, {}, 0.0, {}}; }

Detectable ofSlope(const Fitted& fitted, const NameRule& rule) {
  return detectableBeside(fitted.fit, fitted.drive, screen(fitted.fit, fitted.drive, {"ocv_soc"}, 1), rule, 1).front();
}

Detectable ofSlope(double noise, DiagnosisThresholds thresholds = {}) { return ofSlope(fittedWith(noise), by(thresholds)); }

/// The names of a search for the slope alone where the battery has so much of it [V/Ah].
std::vector<Accepted> namesWith(double slope) {
  Series series = test::baseDrive(5, 600.0, 0.002);
  double charge = 0.0;
  for (std::size_t n = 0; n < series.size(); ++n) {
    if (n > 0) charge += 0.5 * (series.current[n - 1] + series.current[n]) * (series.time[n] - series.time[n - 1]) / 3600.0;
    series.voltage[n] += slope * charge;
  }
  const Drive drive = compressedDrive(series, {0, series.size()});
  NamingOptions options;
  options.hypotheses = {"ocv_soc"};
  const BatteryModel model;
  return nameEffects(drive, fitWhitened(model, drive, {typicalStart(model, drive)}, std::nullopt), options).accepted;
}

TEST(Detectable, TenTimesTheNoiseTakesTenTimesTheStrength) {
  EXPECT_NEAR(10.0, *ofSlope(0.02).strength / *ofSlope(0.002).strength, 1.0);
}

TEST(Detectable, WhatANameMustTakeOutOfTheErrorCounts) {
  DiagnosisThresholds strict;
  strict.least_share = 0.5;  // the error must fall by half: the effect must be sqrt(3) times what is left
  DiagnosisThresholds stricter;
  stricter.least_share = 0.75;  // sqrt(15) times
  EXPECT_NEAR(std::sqrt(5.0), *ofSlope(0.002, stricter).strength / *ofSlope(0.002, strict).strength, 1e-6);
}

TEST(Detectable, WhatIsLeftAndStrongerWouldBeTakenFirst) {
  const Fitted fitted = fittedWith(0.002);
  DiagnosisThresholds by_evidence;
  by_evidence.least_share = 1e-6;
  std::vector<Signature> screened = screen(fitted.fit, fitted.drive, {"ocv_soc", "cpe2"}, 1);
  screened[1].score = 900.0;
  const double once = detectableBeside(fitted.fit, fitted.drive, screened, by(by_evidence), 1).front().strength.value();
  screened[1].score = 3600.0;
  EXPECT_NEAR(2.0, *detectableBeside(fitted.fit, fitted.drive, screened, by(by_evidence), 1).front().strength / once, 1e-6);
}

TEST(Detectable, AUsualStrengthIsVisibleWhereItIsLargerThanTheLeast) {
  const Detectable one = ofSlope(1e-4);
  EXPECT_EQ("ocv_slope", one.parameter);
  EXPECT_EQ(one.visible, *one.strength <= one.typical);
  EXPECT_TRUE(one.visible);
  EXPECT_FALSE(ofSlope(0.1).visible);
}

TEST(Detectable, WhatIsPromisedIsNamed) {
  const double promised = *ofSlope(0.002).strength;
  const std::vector<Accepted> found = namesWith(1.2 * promised);
  ASSERT_EQ(1u, found.size());
  EXPECT_EQ("ocv_soc", found.front().id);
  EXPECT_TRUE(namesWith(0.3 * promised).empty());
}

TEST(Detectable, WhereSomethingUnknownIsLeftItTakesMore) {
  const Fitted fitted = fittedWith(0.002);
  NameRule rule = by({});
  const double alone = *ofSlope(fitted, rule).strength;
  rule.least_gain = 100.0;
  EXPECT_GT(*ofSlope(fitted, rule).strength, 1.5 * alone);
  EXPECT_EQ(std::nullopt, ofSlope(fitted, {rule.thresholds, {}, 1e9, {}}).strength);
}

TEST(Detectable, WhatIsToBeConfirmedIsRaisedUntilItIsNamed) {
  const Fitted fitted = fittedWith(0.002);
  NameRule rule = by({});
  const double tried = *ofSlope(fitted, rule).strength;
  int asked = 0;
  double least = 1.5 * tried;
  rule.confirm = {"ocv_soc"};
  rule.is_named = [&](const BatteryModel& larger, const CompositionPoint& point, const std::string& id) {
    ++asked;
    EXPECT_EQ("ocv_soc", id);
    return std::abs(point.parameters[*larger.parameterRow("ocv_slope")]) >= least;
  };
  EXPECT_NEAR(2.0 * tried, ofSlope(fitted, rule).strength.value(), 1e-9 * tried);
  EXPECT_GE(asked, 2);
  least = std::numeric_limits<double>::infinity();
  EXPECT_EQ(std::nullopt, ofSlope(fitted, rule).strength);
  rule.confirm = {"gassing"};
  EXPECT_EQ(tried, *ofSlope(fitted, rule).strength);
}

TEST(Detectable, NoStrengthIsPromisedBeyondTheCataloguesRange) {
  const Detectable one = ofSlope(2.0);
  EXPECT_EQ(std::nullopt, one.strength);
  EXPECT_FALSE(one.visible);
}

}  // namespace
}  // namespace battery_sof
