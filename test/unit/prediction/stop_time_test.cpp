#include "prediction/questions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/known_model.hpp"

namespace battery_sof {
namespace {

using namespace test;

StopTimeQuery usualQuery(double u_required) {
  StopTimeQuery query;
  query.i_load = -25.0;
  query.i_cranking = -200.0;
  query.t_cranking = 1.0;
  query.u_required = u_required;
  return query;
}

CrankingQuery crankAfter(const StopTimeQuery& query, double t_stop) {
  return {query.i_load, t_stop, query.i_cranking, query.t_cranking, askedFor(query.u_required)};
}

/**
 * The base model's own stop time. With x = exp(beta u_c2 / 2) a held current gives
 *
 *     dx/dt = -(beta I_0 / 2 C_2) (x - x_p)(x - x_m),   x_pm = (i +- R) / 2 I_0,   R = sqrt(i^2 + 4 I_0^2)
 *
 * so (x - x_p)/(x - x_m) decays by lambda = beta R / 2 C_2.
 */
struct HeldCurrent {
  double x_p, x_m, lambda;
  HeldCurrent(const BaseParameters& b, double i) {
    const double root = std::sqrt(i * i + 4.0 * b.i0 * b.i0);
    x_p = (i + root) / (2.0 * b.i0);
    x_m = (i - root) / (2.0 * b.i0);
    lambda = b.beta * root / (2.0 * b.c2);
  }
  double ratio(double x) const { return (x - x_p) / (x - x_m); }
  double timeBetween(double from, double to) const {
    return std::log(ratio(from) / ratio(to)) / lambda;
  }
  double before(double x, double time) const {
    const double q = ratio(x) * std::exp(lambda * time);
    return (x_p - q * x_m) / (1.0 - q);
  }
};

double closedForm(const FittedModel& model, const StopTimeQuery& q) {
  const BaseParameters& b = model.fit.parameters;
  const double u_end = q.u_required - b.u_dc - b.r_discharge * q.i_cranking;
  const double x_end = std::exp(0.5 * b.beta * u_end);
  const double x_begin = HeldCurrent(b, q.i_cranking).before(x_end, q.t_cranking);
  return HeldCurrent(b, q.i_load)
      .timeBetween(std::exp(0.5 * b.beta * model.state.states[0]), x_begin);
}

TEST(PredictStopTime, IsTheClosedFormOfTheBaseModel) {
  const FittedModel model = knownModel();
  for (const double t : {1.0, 7.0, 23.0, 60.0}) {
    StopTimeQuery query = usualQuery(0.0);
    query.u_required = predictCranking(model, crankAfter(query, t)).u_min->value;
    const double expected = closedForm(model, query);
    ASSERT_NEAR(expected, t, 1e-6 * t) << "the closed form inverts the simulation";
    const StopTimeAnswer answer = predictStopTime(model, query);
    ASSERT_EQ(answer.outcome, StopTimeOutcome::kFinite) << answer.message;
    EXPECT_NEAR(answer.t_stop->value, expected, std::max(0.1, 0.01 * expected));
    EXPECT_TRUE(answer.monotone);
    EXPECT_TRUE(answer.valid) << answer.message;
  }
}

TEST(PredictStopTime, InvertsTheCrankOfCompositionsToo) {
  for (const auto& effects : {std::vector<std::string>{"acid_transport"},
                              std::vector<std::string>{"ocv_soc", "current_dependent_resistance"},
                              std::vector<std::string>{"self_heating", "cpe2"}}) {
    const FittedModel model = knownModel(effects);
    StopTimeQuery query = usualQuery(0.0);
    query.u_required = predictCranking(model, crankAfter(query, 40.0)).u_min->value;
    const StopTimeAnswer answer = predictStopTime(model, query);
    ASSERT_EQ(answer.outcome, StopTimeOutcome::kFinite) << effects.front() << answer.message;
    EXPECT_NEAR(answer.t_stop->value, 40.0, 0.5) << effects.front();
  }
}

TEST(PredictStopTime, SaysAlwaysWhenTheSettledBatteryStillHolds) {
  StopTimeQuery query = usualQuery(7.2);
  query.i_load = 0.0;
  const StopTimeAnswer answer = predictStopTime(knownModel(), query);
  EXPECT_EQ(answer.outcome, StopTimeOutcome::kAlways);
  EXPECT_TRUE(std::isinf(answer.t_stop->value));
  EXPECT_TRUE(answer.valid) << answer.message;
}

TEST(PredictStopTime, SaysNeverWhenTheCrankFailsAtOnce) {
  const StopTimeAnswer answer = predictStopTime(knownModel(), usualQuery(12.6));
  EXPECT_EQ(answer.outcome, StopTimeOutcome::kNever);
  EXPECT_EQ(answer.t_stop->value, 0.0);
}

TEST(PredictStopTime, IsNotMonotoneWhileTheBatteryRecoversAndTheFirstCrossingCounts) {
  const BaseParameters battery = drivenBattery();
  const FittedModel model = knownModel({}, test::settledOverpotential(battery, -300.0));
  const double at_once = predictCranking(model, crankAfter(usualQuery(0.0), 0.0)).u_min->value;
  const StopTimeAnswer holds_now = predictStopTime(model, usualQuery(at_once - 0.01));
  EXPECT_FALSE(holds_now.monotone);
  EXPECT_EQ(holds_now.outcome, StopTimeOutcome::kAtLeast) << holds_now.message;

  const StopTimeAnswer fails_now = predictStopTime(model, usualQuery(at_once + 0.01));
  EXPECT_EQ(fails_now.outcome, StopTimeOutcome::kNever);
  EXPECT_EQ(fails_now.t_stop->value, 0.0);
}

TEST(PredictStopTime, IntervalEndsWhereTheCranksBoundsStopToHold) {
  const FittedModel model = uncertainModel(0.002);
  StopTimeQuery query = usualQuery(0.0);
  query.u_required = predictCranking(model, crankAfter(query, 10.0)).u_min->value;
  const Interval t = *predictStopTime(model, query).t_stop;
  EXPECT_NEAR(t.value, 10.0, 0.1);
  ASSERT_LT(t.lower, t.value);
  ASSERT_GT(t.upper, t.value);
  ASSERT_GT(t.lower, 0.0);
  EXPECT_NEAR(predictCranking(model, crankAfter(query, t.lower)).u_min->lower, query.u_required,
              2e-3);
  ASSERT_TRUE(std::isfinite(t.upper));
  EXPECT_NEAR(predictCranking(model, crankAfter(query, t.upper)).u_min->upper, query.u_required,
              2e-3);
}

TEST(PredictStopTime, IsAtLeastTheStopThatDrawsTwoPercentOfTheCapacity) {
  const StopTimeAnswer answer = predictStopTime(knownModel(), usualQuery(7.2), 50.0);
  EXPECT_EQ(answer.outcome, StopTimeOutcome::kAtLeast);
  EXPECT_NEAR(answer.t_stop->value, 144.0, 1e-9) << "1 Ah at 25 A";
  EXPECT_NEAR(answer.t_stop->upper, 7200.0, 1e-9) << "50 Ah at 25 A";
  EXPECT_EQ(answer.t_stop->lower, answer.t_stop->value);
  EXPECT_TRUE(answer.valid) << answer.message;
  EXPECT_TRUE(holds(answer.message, "at least 144.0 s")) << answer.message;
}

TEST(PredictStopTime, IsAtLeastTheStopThatDrawsTheSupportedCharge) {
  FittedModel model = knownModel({"ocv_soc"});
  for (const double swing : {0.0, 2.0}) {
    model.fit.excited.charge_swing = swing;
    const double supported = supportedCharge(model.fit, 50.0);
    const StopTimeAnswer answer = predictStopTime(model, usualQuery(0.1), 50.0);
    EXPECT_EQ(answer.outcome, StopTimeOutcome::kAtLeast) << swing;
    EXPECT_NEAR(answer.t_stop->value, supported * 3600.0 / 25.0, 1e-9) << swing;
    EXPECT_TRUE(answer.valid) << answer.message;
  }
}

TEST(PredictStopTime, ACrossingBeyondTheChargeTheModelHoldsIsOnlySaid) {
  const FittedModel model = knownModel();
  StopTimeQuery query = usualQuery(0.0);
  query.u_required = predictCranking(model, crankAfter(query, 40.0), 10.0).u_min->value;
  const StopTimeAnswer answer = predictStopTime(model, query, 10.0);
  EXPECT_EQ(answer.outcome, StopTimeOutcome::kAtLeast);
  EXPECT_NEAR(answer.t_stop->value, 28.8, 1e-9) << "0.2 Ah at 25 A";
  EXPECT_GT(answer.t_stop->upper, 40.0) << "the slope is not known exactly";
  EXPECT_LT(answer.t_stop->upper, 100.0);
  EXPECT_TRUE(holds(answer.message, "puts the end at 4") ||
              holds(answer.message, "puts the end at 39"))
      << answer.message;
}

TEST(PredictStopTime, IsAtLeastADayWhereADayDrawsLess) {
  StopTimeQuery query = usualQuery(7.2);
  query.i_load = -0.01;
  const StopTimeAnswer answer = predictStopTime(knownModel(), query, 50.0);
  EXPECT_EQ(answer.outcome, StopTimeOutcome::kAtLeast);
  EXPECT_EQ(answer.t_stop->value, 86400.0);
  EXPECT_TRUE(answer.valid) << answer.message;
}

TEST(PredictStopTime, AnIntervalFromNoStopToTheLongestSaysNothing) {
  FittedModel model = knownModel();
  StopTimeQuery query = usualQuery(0.0);
  query.u_required = predictCranking(model, crankAfter(query, 10.0)).u_min->value;
  EXPECT_TRUE(predictStopTime(model, query).valid);
  model.fit.estimates[4].std = 1.0;  // u_dc [V]
  model.fit.covariance(4, 4) = 1.0;
  const StopTimeAnswer answer = predictStopTime(model, query);
  EXPECT_FALSE(answer.valid);
  EXPECT_EQ(answer.t_stop->lower, 0.0);
  EXPECT_TRUE(holds(answer.message, "is of no use, expected narrower than")) << answer.message;
  EXPECT_TRUE(holds(answer.message, "the stop that discharges the whole battery"))
      << answer.message;
  query.i_load = 0.0;
  EXPECT_TRUE(holds(predictStopTime(model, query).message, "s, a day"))
      << predictStopTime(model, query).message;
}

TEST(PredictStopTime, NeverDrawsMoreThanTheBatteryHolds) {
  constexpr double kRounding = 1e-9;  // [Ah]
  for (const auto& effects :
       {std::vector<std::string>{}, std::vector<std::string>{"acid_transport"},
        std::vector<std::string>{"ocv_soc"}, std::vector<std::string>{"self_heating", "cpe2"}})
    for (const double capacity : {0.5, 50.0, 200.0})
      for (const double i_load : {-1e-3, -0.5, -5.0, -20.0, -75.0, -400.0, -5000.0})
        for (const double u_required : {0.1, 7.2, 10.5, 11.3, 11.45, 12.6}) {
          StopTimeQuery query = usualQuery(u_required);
          query.i_load = i_load;
          const StopTimeAnswer answer =
              predictStopTime(uncertainModel(0.002, effects), query, capacity);
          ASSERT_TRUE(answer.t_stop) << answer.message;
          EXPECT_NE(answer.outcome, StopTimeOutcome::kAlways) << i_load;
          EXPECT_LE(answer.t_stop->lower, answer.t_stop->value);
          EXPECT_LE(answer.t_stop->value, answer.t_stop->upper);
          EXPECT_LE(-i_load * answer.t_stop->upper / 3600.0, capacity + kRounding)
              << i_load << " A, " << capacity << " Ah: " << answer.message;
        }
}

TEST(PredictStopTime, RefusesImpossibleQueriesAndNamesWhatWasExpected) {
  const auto refused = [](auto change, const std::string& name, const std::string& expected) {
    StopTimeQuery query = usualQuery(7.2);
    change(query);
    const StopTimeAnswer answer = predictStopTime(knownModel(), query);
    EXPECT_EQ(answer.code, AnswerCode::kInvalidQuery) << name;
    EXPECT_FALSE(answer.t_stop || answer.valid) << name;
    EXPECT_TRUE(holds(answer.message, name) && holds(answer.message, expected)) << answer.message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused([](auto& q) { q.i_load = 5.0; }, "i_load [A] is 5", "-5000 to 0");
  refused([&](auto& q) { q.i_load = nan; }, "i_load", "-5000 to 0");
  refused([](auto& q) { q.i_cranking = 0.0; }, "i_cranking [A] is 0", "below 0");
  refused([](auto& q) { q.t_cranking = 61.0; }, "t_cranking [s] is 61", "up to 60");
  refused([&](auto& q) { q.u_required = nan; }, "no limit is given",
          "u_required [V] is nan, expected above 0, up to 100");
  refused([&](auto& q) { q.u_required = 0.0; }, "no limit is given",
          "u_required [V] is 0, expected above 0, up to 100");
  refused([](auto& q) { q.crank = {{0.0, 1.0}, {-200.0}}; }, "2 times and 1 currents", "as many");
}

TEST(PredictStopTime, HasNoAnswerFromAModelThatCannotBeUsed) {
  FittedModel model = knownModel();
  model.fit.status = FitStatus::kNotExcited;
  const StopTimeAnswer answer = predictStopTime(model, usualQuery(7.2));
  EXPECT_EQ(answer.code, AnswerCode::kNoModel);
  EXPECT_FALSE(answer.t_stop);
}

}  // namespace
}  // namespace battery_sof
