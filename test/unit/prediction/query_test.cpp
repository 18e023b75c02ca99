
#include <gtest/gtest.h>

#include <limits>

#include "prediction/questions.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

using namespace test;

constexpr double kCapacity = 50.0;

std::string reasonFor(const FittedModel& model, void (*change)(QueryRange&)) {
  QueryRange range;
  range.min_current = -200.0;
  range.max_current = 50.0;
  range.max_voltage = 14.2;
  change(range);
  return toString(extrapolationOf(model, range, kCapacity), 1.0);
}

std::string textOf(const std::optional<Reason>& reason, double series_blocks = 1.0) {
  return reason ? toString(*reason, series_blocks) : "";
}

Interval at(double voltage) { return {voltage, voltage, voltage}; }

TEST(AskedFor, ZeroAndNanAskForNothing) {
  EXPECT_FALSE(askedFor(0.0));
  EXPECT_FALSE(askedFor(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(askedFor(std::nullopt));
  EXPECT_EQ(askedFor(7.2), 7.2);
  EXPECT_EQ(askedFor(-1.0), -1.0);
}

TEST(ExtrapolationOf, FindsNothingInWhatTheWindowExcited) {
  EXPECT_EQ(reasonFor(knownModel(), [](QueryRange&) {}), "");
}

TEST(ExtrapolationOf, GivesEachReasonAlone) {
  const FittedModel model = knownModel();
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.min_current = -501.0; }),
            "it draws -501 A but the window's largest discharge was -400 A");
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.max_current = 501.0; }),
            "it charges with 501 A but the window's largest charge was 400 A");
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.max_voltage = 15.4; }),
            "it goes to 15.40 V but the window's highest voltage was 15.00 V");
  EXPECT_TRUE(
      holds(reasonFor(model, [](QueryRange& r) { r.charge_moved = 1.1; }), "it moves 1.10 Ah"));
}

TEST(ExtrapolationOf, AllowsWhatIsWithinReach) {
  const FittedModel model = knownModel();
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.min_current = -499.0; }), "");
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.max_voltage = 15.2; }), "");
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.charge_moved = 1.0; }), "");
}

TEST(ExtrapolationOf, NoBatteryHasAVoltageBelowZeroOrAboveSixteenVoltsABlock) {
  FittedModel model = knownModel();
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.answered_voltage = at(0.0); }), "");
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.answered_voltage = at(16.0); }), "");
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.answered_voltage = at(-0.5); }),
            "its result is -0.50 V, expected 0 to 16 V for such a battery");
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.answered_voltage = at(16.5); }),
            "its result is 16.50 V, expected 0 to 16 V for such a battery");
  model.fit.parameters.u_dc = 25.2;
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.answered_voltage = at(30.0); }), "");
}

TEST(VoltageSaysNothing, WhereItsIntervalLeavesABatterysVoltagesOrHoldsAsGoodAsAllOfThem) {
  Fit fit = knownModel().fit;
  EXPECT_FALSE(voltageSaysNothing(fit, {9.0, 6.5, 11.5}));
  EXPECT_EQ(textOf(voltageSaysNothing(fit, {1.0, -0.5, 2.5})),
            "its 90 % interval of -0.50 to 2.50 V is of no use, expected inside 0 to 16 V and "
            "narrower than 10 V");
  EXPECT_EQ(textOf(voltageSaysNothing(fit, {1.0, -0.5, 2.5}), 2.0),
            "its 90 % interval of -1.00 to 5.00 V is of no use, expected inside 0 to 32 V and "
            "narrower than 20 V")
      << "told of the row";
  EXPECT_TRUE(voltageSaysNothing(fit, {14.0, 11.0, 17.0}));
  EXPECT_TRUE(voltageSaysNothing(fit, {8.0, 3.0, 13.0}));
  fit.parameters.u_dc = 25.2;  // two blocks fitted as one
  EXPECT_FALSE(voltageSaysNothing(fit, {18.0, 9.0, 27.0}));
}

TEST(WidthSaysNothing, WhereAnIntervalIsNotNarrowerThanWhatIsKnownWithoutAModel) {
  const auto reason = [](ReasonKind kind, double upper) {
    return textOf(widthSaysNothing(kind, {5.0, 0.0, upper}, 10.0, "the limit"), 2.0);
  };
  EXPECT_EQ(reason(ReasonKind::kWideCurrent, 9.5), "");
  EXPECT_EQ(
      reason(ReasonKind::kWideCurrent, 10.0),
      "its 90 % interval of 0.0 to 10.0 A is of no use, expected narrower than 10.0 A, the limit");
  EXPECT_EQ(
      reason(ReasonKind::kWideStop, 10.0),
      "its 90 % interval of 0.0 to 10.0 s is of no use, expected narrower than 10.0 s, the limit");
}

TEST(ExtrapolationOf, ReasonsAreOfOneBlockAndToldOfTheRow) {
  FittedModel model = uncertainModel(0.002);
  model.intervals.missed_answer = MissedAnswer{0.0, 8.0, 9.0, 9.5};
  model.fit.scores.cranks = 3;
  model.fit.scores.crank_error_std = 0.5;
  model.fit.baseline.cranks = BaselineCranks{};
  model.fit.series_blocks = 2.0;
  const CrankingAnswer answer = predictCranking(model, {-20.0, 30.0, -200.0, 1.0, 14.4});
  EXPECT_TRUE(holds(answer.message, "reached 16.00 V, outside the predicted 18.00 to 19.00 V"))
      << answer.message;
  EXPECT_TRUE(holds(answer.message, "cranks by 1000 mV RMS, the baseline by 0 mV"))
      << answer.message;
}

TEST(ExtrapolationOf, TheFirstSampleOfAProfileThatSaysNothingIsNamed) {
  FittedModel model = uncertainModel(0.002);
  const double std = 1.0;  // [Ohm]
  model.fit.estimates[kRowRDischarge].std = std;
  model.fit.covariance(kRowRDischarge, kRowRDischarge) = std * std;
  const ProfileAnswer answer = simulateProfile(model, {60.0, 120.0, 180.0}, {0.0, -20.0, -20.0});
  EXPECT_TRUE(holds(answer.message, "sample 1: its 90 % interval of ")) << answer.message;
}

/// Their covariances are those of files that are read; answers with them were called valid.
TEST(ExtrapolationOf, AnIntervalThatSaysNothingIsNoValidAnswerToAnyQuestion) {
  for (const int row : {0, 1, 2, 3, 4}) {  // r_discharge, r_charge, c2, beta, u_dc
    FittedModel model = uncertainModel(0.002);
    const double std = 1e6 * *model.fit.estimates[static_cast<std::size_t>(row)].std;
    model.fit.estimates[static_cast<std::size_t>(row)].std = std;
    model.fit.covariance(row, row) = std * std;
    const CrankingAnswer crank = predictCranking(model, {-20.0, 30.0, -200.0, 1.0, 7.2});
    const StopTimeAnswer stop = predictStopTime(model, {-20.0, -200.0, 1.0, 7.2});
    const ChargeAcceptanceAnswer charge = predictChargeAcceptance(model, {13.4, 10.0, 5000.0});
    const ProfileAnswer profile = simulateProfile(model, {60.0, 120.0}, {-20.0, 20.0});
    const bool charges_only = row == 1;
    for (const auto& [valid, message] :
         {std::pair(crank.valid, crank.message), std::pair(stop.valid, stop.message)}) {
      EXPECT_EQ(valid, charges_only) << row << ": " << message;
      EXPECT_EQ(holds(message, "is of no use"), !charges_only) << message;
    }
    const bool discharges_only = row == 0;
    EXPECT_EQ(charge.valid, discharges_only) << row << ": " << charge.message;
    EXPECT_EQ(holds(charge.message, "is of no use"), !discharges_only)
        << row << ": " << charge.message;
    EXPECT_FALSE(profile.valid) << row;
    EXPECT_TRUE(holds(profile.message, "is of no use")) << row << ": " << profile.message;
  }
}

TEST(ExtrapolationOf, ACrankThatComesToLessThanNothingIsNotValidAndNeitherIsItsStopTime) {
  FittedModel model = knownModel();
  model.fit.parameters.r_discharge = model.fit.estimates[kRowRDischarge].value = 0.06;
  const CrankingAnswer crank = predictCranking(model, {-1.0, 10.0, -300.0, 0.5});
  EXPECT_LT(crank.u_min->value, 0.0);
  EXPECT_FALSE(crank.valid);
  EXPECT_EQ(crank.code, AnswerCode::kExtrapolation);
  EXPECT_FALSE(predictStopTime(model, {-1.0, -300.0, 0.5, 7.2}).valid);
}

TEST(ExtrapolationOf, WhatAModelMakesNoFiniteNumbersOfIsAnsweredWithoutNumbers) {
  FittedModel model = knownModel({"voltage_drift"});
  for (ParameterEstimate& estimate : model.fit.estimates)
    if (estimate.name == "u_dc" || estimate.name == "voltage_drift") estimate.value = 1.7e308;
  takeEstimates(model.fit);
  const CrankingAnswer crank = predictCranking(model, {-1.0, 3600.0, -200.0, 0.5});
  EXPECT_EQ(crank.code, AnswerCode::kNoModel);
  EXPECT_FALSE(crank.u_min || crank.capable || crank.valid);
  EXPECT_TRUE(holds(crank.message, "no finite result"));
  const StopTimeAnswer stop = predictStopTime(model, {-1.0, -200.0, 0.5, 7.2});
  EXPECT_EQ(stop.code, AnswerCode::kNoModel);
  EXPECT_FALSE(stop.t_stop || stop.valid);
  const ProfileAnswer profile = simulateProfile(model, {1.0, 3600.0}, {-1.0, -1.0});
  EXPECT_EQ(profile.code, AnswerCode::kNoModel);
  EXPECT_TRUE(profile.predicted.voltage.empty() && profile.predicted.lower.empty());
}

TEST(SupportedCharge, IsWhatTheWindowMovedWhereItDeterminedAPhysicalSlopeElseTwoPercent) {
  FittedModel model = knownModel({"ocv_soc"});
  ParameterEstimate& slope = model.fit.estimates[kBaseRows];
  ASSERT_EQ(slope.name, "ocv_slope");
  const auto supported = [&](double of_block, double swing) {
    slope.value = of_block / kCapacity;
    model.fit.excited.charge_swing = swing;
    return supportedCharge(model.fit, kCapacity);
  };
  EXPECT_DOUBLE_EQ(supported(1.2, 3.0), 3.0);
  EXPECT_DOUBLE_EQ(supported(1.2, 0.1), 1.0) << "never less than the 2 % of any battery";
  EXPECT_DOUBLE_EQ(supported(1.2, 80.0), 50.0) << "nor more than the battery holds";
  for (const double not_physical : {6.7, 1.9, 0.7, 0.0, -1.2})
    EXPECT_DOUBLE_EQ(supported(not_physical, 3.0), 1.0) << not_physical;
  slope.determined = false;
  EXPECT_DOUBLE_EQ(supported(1.2, 3.0), 1.0);
  slope.determined = true;
  slope.held = true;
  EXPECT_DOUBLE_EQ(supported(1.2, 3.0), 1.0);
  model.fit.parameters.u_dc = 25.2;  // two blocks fitted as one
  slope.held = false;
  EXPECT_DOUBLE_EQ(supported(2.4, 3.0), 3.0);
}

TEST(SupportedCharge, IsTwoPercentOfAStopAndOneOfAChargeWithoutASlopeWhateverRelaxes) {
  for (const auto& effects :
       {std::vector<std::string>{}, std::vector<std::string>{"acid_transport"}}) {
    FittedModel model = knownModel(effects);
    model.fit.excited.charge_swing = 20.0;
    EXPECT_DOUBLE_EQ(supportedCharge(model.fit, kCapacity), 1.0);
    EXPECT_DOUBLE_EQ(supportedCharge(model.fit, kCapacity, true), 0.5);
    EXPECT_TRUE(holds(reasonFor(model, [](QueryRange& r) { r.charge_moved = 2.0; }),
                      "it moves 2.00 Ah but the model supports at most 1.00 Ah"));
    EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.charge_moved = 51.0; }),
              "it moves 51 Ah, more than the battery's 50 Ah");
  }
}

TEST(OpenCircuitFall, IsTwelveMillivoltsForEachPercentBeyondTheFirst) {
  FittedModel model = knownModel();
  EXPECT_EQ(openCircuitFall(model.fit, 0.5, kCapacity).mean, 0.0) << "the paper's constant voltage";
  EXPECT_EQ(openCircuitFall(model.fit, -5.0, kCapacity).mean, 0.0) << "nothing was drawn";
  const ErrorForecast fall = openCircuitFall(model.fit, 1.5, kCapacity);
  EXPECT_NEAR(fall.mean, -0.024, 1e-12);
  EXPECT_NEAR(std::sqrt(fall.variance), 0.008, 1e-12);
  model.fit.parameters.u_dc = 25.2;  // two blocks fitted as one
  EXPECT_NEAR(openCircuitFall(model.fit, 1.5, kCapacity).mean, -0.048, 1e-12);
}

TEST(OpenCircuitFall, IsTheEquationsOwnWhereTheWindowDeterminedIt) {
  FittedModel model = knownModel({"ocv_soc"});
  model.fit.estimates[kBaseRows].value = 1.2 / kCapacity;
  EXPECT_EQ(openCircuitFall(model.fit, 1.5, kCapacity).mean, 0.0);
}

TEST(ExtrapolationOf, TemperatureCountsWhenBothAreKnown) {
  FittedModel model = knownModel();
  const auto cold = [](QueryRange& r) { r.temperature = 263.15; };
  EXPECT_EQ(reasonFor(model, cold), "");
  model.fit.excited.temperature = 293.15;
  EXPECT_EQ(reasonFor(model, cold),
            "the battery is at -10 degC but in the window it was at 20 degC");
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.temperature = 300.0; }), "");
}

TEST(ExtrapolationOf, LongChargesWantAnAcceptanceLimitAndALongChargeInTheWindow) {
  const auto twenty_seconds = [](QueryRange& r) {
    r.charges = true;
    r.charge_duration = 20.0;
  };
  EXPECT_TRUE(holds(reasonFor(knownModel(), twenty_seconds), "effect charge_acceptance"));
  FittedModel model = knownModel({"charge_acceptance"});
  EXPECT_EQ(reasonFor(model, twenty_seconds), "");
  model.fit.excited.longest_charge = 4.0;
  EXPECT_EQ(reasonFor(model, twenty_seconds),
            "the window's longest charge lasted 4.0 s, but at least 10 s are needed");
}

TEST(ExtrapolationOf, NamesTheResistanceTheWindowDidNotDetermine) {
  FittedModel model = knownModel();
  model.fit.estimates[0].determined = false;  // r_discharge
  EXPECT_EQ(reasonFor(model, [](QueryRange&) {}), "the window did not determine r_discharge");
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.charges = true; }), "");
  model.fit.estimates[1].determined = false;
  EXPECT_EQ(reasonFor(model, [](QueryRange& r) { r.charges = true; }),
            "the window did not determine r_charge");
}

TEST(ExtrapolationOf, JoinsSeveralReasons) {
  const std::string reasons = reasonFor(knownModel(), [](QueryRange& r) {
    r.min_current = -900.0;
    r.charge_moved = 5.0;
  });
  EXPECT_TRUE(holds(reasons, "draws") && holds(reasons, "; ") && holds(reasons, "moves"));
}

TEST(FaultOf, NamesTheFirstFaultOfAProfileAndWhatWasExpected) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto faultOf = [](const CurrentProfile& profile, const char* name) {
    return battery_sof::faultOf(profile.time, profile.current, name, 2).value_or("none");
  };
  EXPECT_EQ(faultOf({{0.0, 1.0, 2.0}, {-5.0, -5.0, -5.0}}, "load"),
            "load has 3 points, expected at most 2");
  EXPECT_EQ(faultOf({{0.0, 1.0}, {-5.0, -5.0}}, "load"), "none");
  EXPECT_EQ(faultOf({}, "load"), "none");
  EXPECT_EQ(faultOf({{0.0, 1.0}, {-5.0}}, "load"),
            "load has 2 times and 1 currents, expected as many");
  EXPECT_TRUE(holds(faultOf({{0.0, nan}, {-5.0, -5.0}}, "load"),
                    "load time[1] is nan s, expected 0 to 86400"));
  EXPECT_TRUE(
      holds(faultOf({{1.0, 1.0}, {-5.0, -5.0}}, "load"), "expected more than the one before"));
  EXPECT_TRUE(holds(faultOf({{5e-324, 1.0}, {-5.0, -5.0}}, "load"),
                    "load time[0] is 4.94066e-324 s after the one before, expected at least"));
  EXPECT_TRUE(holds(faultOf({{0.0, 1.0}, {-5.0, nan}}, "crank"),
                    "crank current[1] is nan A, expected -5000 to 5000"));
}

TEST(FaultOf, AValueJustBeyondItsLimitDoesNotReadAsTheLimit) {
  const auto faultOf = [](const CurrentProfile& profile) {
    return battery_sof::faultOf(profile.time, profile.current, "load", 2).value_or("none");
  };
  const double close = 1.2e-6 - 1.1e-6;
  ASSERT_LT(close, 1e-7);
  EXPECT_EQ(faultOf({{0.0, close}, {-5.0, -5.0}}).find(" is 1e-07 s"), std::string::npos);
  EXPECT_TRUE(holds(faultOf({{0.0, close}, {-5.0, -5.0}}), " is 9.999999"));
  EXPECT_TRUE(holds(faultOf({{0.0, 86400.0001}, {-5.0, -5.0}}), " is 86400.0001 s"));
  EXPECT_TRUE(holds(faultOf({{0.0, 1.0}, {-5.0, -5000.0001}}), " is -5000.0001 A"));
}

}  // namespace
}  // namespace battery_sof
