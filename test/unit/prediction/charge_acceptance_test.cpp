#include "prediction/questions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/known_model.hpp"

namespace battery_sof {
namespace {

using namespace test;

/// Mean current of the base model at a held voltage, in steps so short that their order does not
/// matter.
double byFineSteps(const BaseParameters& b, double u_c2, double u_boost, double duration,
                   double i_limit) {
  constexpr double kStep = 2e-4;
  const test::BaseStep step(b);
  double charge = 0.0;
  const long steps = std::lround(duration / kStep);
  for (long n = 0; n < steps; ++n) {
    const double left = u_boost - b.u_dc - u_c2;
    const double i = std::min(left / (left < 0.0 ? b.r_discharge : b.r_charge), i_limit);
    u_c2 = step.advance(u_c2, i, kStep);
    charge += i * kStep;
  }
  return charge / duration;
}

/// The same by the query's own steps, each solved by bisection: i = (u_boost - u_dc - u_c2) / r at
/// the step's end.
double byItsOwnSteps(const BaseParameters& b, double u_c2, double u_boost, double duration) {
  const test::BaseStep step(b);
  double charge = 0.0, since = 0.0, dt = 0.02;
  while (since < duration * (1.0 - 1e-9)) {
    const double h = std::min(dt, duration - since);
    double low = -5000.0, high = 5000.0;
    for (int k = 0; k < 100; ++k) {
      const double i = 0.5 * (low + high);
      (test::terminalVoltage(b, i, step.advance(u_c2, i, h)) < u_boost ? low : high) = i;
    }
    u_c2 = step.advance(u_c2, low, h);
    charge += low * h;
    since += h;
    dt = std::min(1.15 * dt, std::max(0.02, duration / 100.0));
  }
  return charge / duration;
}

TEST(PredictChargeAcceptance, IsTheBaseModelsOwnCurrentStepByStep) {
  const BaseParameters battery = drivenBattery();
  for (const double u_boost : {12.4, 13.2, 14.2, 14.8})
    for (const double duration : {0.5, 10.0, 60.0})
      for (const double u_c2 : {-0.3, 0.0, 0.2}) {
        const ChargeAcceptanceAnswer answer =
            predictChargeAcceptance(knownModel({}, u_c2), {u_boost, duration, 5000.0}, 1000.0);
        ASSERT_TRUE(answer.i_boost) << answer.message;
        EXPECT_NEAR(answer.i_boost->value, byItsOwnSteps(battery, u_c2, u_boost, duration), 1e-5);
        const double fine = byFineSteps(battery, u_c2, u_boost, duration, 5000.0);
        EXPECT_NEAR(answer.i_boost->value, fine, std::max(0.5, 0.02 * std::abs(fine)));
      }
}

TEST(PredictChargeAcceptance, IsNegativeWhereTheVoltageDischarges) {
  EXPECT_LT(predictChargeAcceptance(knownModel(), {12.5, 10.0, 5000.0}).i_boost->value, 0.0);
}

TEST(PredictChargeAcceptance, StaysAtTheSourcesLimitAndLeavesItWhenTheBatteryFills) {
  const ChargeAcceptanceAnswer always = predictChargeAcceptance(knownModel(), {14.2, 10.0, 40.0});
  EXPECT_EQ(always.i_boost->value, 40.0);
  EXPECT_EQ(always.i_boost->upper, 40.0);
  const double limit = 150.0;
  const ChargeAcceptanceAnswer partly = predictChargeAcceptance(knownModel(), {14.2, 30.0, limit});
  const double fine = byFineSteps(drivenBattery(), 0.0, 14.2, 30.0, limit);
  ASSERT_LT(fine, limit - 5.0) << "the limit is left";
  EXPECT_NEAR(partly.i_boost->value, fine, 0.02 * fine);
  EXPECT_LE(partly.i_boost->upper, limit);
}

TEST(PredictChargeAcceptance, PastChargesTakeNoBoundBeyondTheSourcesLimit) {
  FittedModel model = knownModel();
  for (int k = 0; k < 6; ++k)
    model.intervals.event_history.add(
        {PastEvent::Kind::kCharge, 10.0 * k, 10.0, 0.0, 14.2, 14.2, 90.0 + k, 60.0});
  const ChargeAcceptanceAnswer answer = predictChargeAcceptance(model, {14.2, 10.0, 40.0});
  EXPECT_LE(answer.i_boost->lower, answer.i_boost->value);
  EXPECT_LE(answer.i_boost->value, answer.i_boost->upper);
  EXPECT_LE(answer.i_boost->upper, 40.0);
}

TEST(PredictChargeAcceptance, FollowsEveryCompositionToTheHeldVoltage) {
  for (const EffectInfo& info : effectCatalogue()) {
    const FittedModel model = knownModel(withNeeds(info.id));
    const ChargeAcceptanceAnswer answer = predictChargeAcceptance(model, {14.0, 5.0, 5000.0});
    ASSERT_TRUE(answer.i_boost) << info.id << answer.message;
    EXPECT_GT(answer.i_boost->value, 0.0) << info.id;
  }
}

TEST(PredictChargeAcceptance, IntervalFollowsFromTheParametersErrors) {
  const double share = 1e-3;
  FittedModel model = uncertainModel(share);
  double variance = 0.0;
  const ChargeAcceptanceQuery query{14.2, 10.0, 5000.0};
  const auto at = [&](FittedModel moved, int row, double by) {
    double* const values[] = {&moved.fit.parameters.r_discharge, &moved.fit.parameters.r_charge,
                              &moved.fit.parameters.c2, &moved.fit.parameters.beta,
                              &moved.fit.parameters.u_dc};
    *values[row] += by;
    return predictChargeAcceptance(moved, query).i_boost->value;
  };
  for (int row = 0; row < kBaseRows; ++row) {
    const double std = *model.fit.estimates[static_cast<std::size_t>(row)].std;
    variance += std::pow((at(model, row, std) - at(model, row, -std)) / 2.0, 2);
  }
  const Interval i = *predictChargeAcceptance(model, query).i_boost;
  EXPECT_NEAR(i.upper - i.value, 1.645 * std::sqrt(variance), 0.01 * (i.upper - i.value));
  EXPECT_NEAR(i.value - i.lower, i.upper - i.value, 1e-9);
  model.intervals.calibrations.charges.factor = 3.0;
  const Interval wider = *predictChargeAcceptance(model, query).i_boost;
  EXPECT_NEAR(wider.upper - wider.value, 3.0 * (i.upper - i.value), 1e-6);
}

TEST(PredictChargeAcceptance, RefusesImpossibleQueriesAndNamesWhatWasExpected) {
  const auto refused = [](ChargeAcceptanceQuery query, const std::string& name,
                          const std::string& expected) {
    const ChargeAcceptanceAnswer answer = predictChargeAcceptance(knownModel(), query);
    EXPECT_EQ(answer.code, AnswerCode::kInvalidQuery) << name;
    EXPECT_FALSE(answer.i_boost || answer.valid) << name;
    EXPECT_TRUE(holds(answer.message, name) && holds(answer.message, expected)) << answer.message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused({0.0, 10.0, 100.0}, "u_boost [V] is 0", "above 0, up to 100");
  refused({nan, 10.0, 100.0}, "u_boost", "above 0, up to 100");
  refused({14.2, 0.0, 100.0}, "t_sof2 [s] is 0", "up to 3600");
  refused({14.2, 3601.0, 100.0}, "t_sof2 [s] is 3601", "up to 3600");
  refused({14.2, 10.0, -1.0}, "i_limit [A] is -1", "up to 5000");
  refused({-1.0, nan, nan}, "i_limit", "u_boost");
}

TEST(PredictChargeAcceptance, OfMoreThanTenSecondsWantsALimitOfAcceptanceInTheModel) {
  const ChargeAcceptanceQuery short_one{13.0, 10.0, 5000.0}, long_one{13.0, 11.0, 5000.0};
  EXPECT_TRUE(predictChargeAcceptance(knownModel(), short_one).valid);
  const ChargeAcceptanceAnswer answer = predictChargeAcceptance(knownModel(), long_one);
  EXPECT_FALSE(answer.valid);
  EXPECT_TRUE(holds(answer.message, "charge_acceptance")) << answer.message;
  EXPECT_TRUE(predictChargeAcceptance(knownModel({"charge_acceptance"}), long_one).valid);
}

TEST(PredictChargeAcceptance, HasNoAnswerFromAModelThatCannotBeUsed) {
  FittedModel model = knownModel();
  model.fit.status = FitStatus::kWindowTooShort;
  EXPECT_EQ(predictChargeAcceptance(model, {14.2, 10.0, 100.0}).code, AnswerCode::kNoModel);
}

TEST(CurrentAtVoltage, IsTheCurrentThatFlowedWhenTheModelIsTrue) {
  const BaseParameters battery = drivenBattery();
  const test::BaseStep step(battery);
  const FittedModel model = knownModel();
  Series series;
  double u_c2 = 0.0;
  for (int n = 1; n <= 1000; ++n) {
    const double i = 30.0 + 10.0 * std::sin(0.01 * n);
    u_c2 = step.advance(u_c2, i, 0.01);
    series.append({model.state.time + 0.01 * n, i, test::terminalVoltage(battery, i, u_c2)});
  }
  const EventComparison mean = currentAtVoltage(model, series);
  EXPECT_NEAR(mean.expected.value, mean.measured, 0.02 * mean.measured);
}

}  // namespace
}  // namespace battery_sof
