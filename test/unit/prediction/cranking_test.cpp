#include "prediction/questions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "estimation/identification.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

FittedModel driveModel(std::uint64_t seed = 1) {
  const Series series = test::baseDrive(seed);
  return identify(series, {0, series.size()});
}

CrankingQuery usualQuery() {
  CrankingQuery query;
  query.i_load = -25.0;
  query.t_stop = 30.0;
  query.i_cranking = -200.0;
  query.t_cranking = 0.8;
  query.u_required = 7.2;
  return query;
}

/// Minimum over (t_stop, t_stop + t_cranking] in steps of a millisecond.
double byBruteForce(const FittedModel& model, const CrankingQuery& query) {
  const test::BaseStep step(model.fit.parameters);
  double u = model.state.states[0];
  for (int k = 0; k < std::lround(query.t_stop * 1e3); ++k) u = step.advance(u, query.i_load, 1e-3);
  double lowest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < std::lround(query.t_cranking * 1e3); ++k) {
    u = step.advance(u, query.i_cranking, 1e-3);
    lowest = std::min(lowest, test::terminalVoltage(model.fit.parameters, query.i_cranking, u));
  }
  return lowest;
}

TEST(CrankError, IsThatOfTheWindowsCranksAndGrowsWithTheCurrentWhereThereWasNone) {
  Fit fit;
  fit.scores.rmse = 0.02;
  fit.scores.crank_error_std = 0.3;
  fit.excited.min_current = -50.0;
  fit.excited.max_current = 20.0;
  EXPECT_DOUBLE_EQ(crankError(fit, -200.0), 0.08);
  EXPECT_DOUBLE_EQ(crankError(fit, -10.0), 0.02);
  fit.scores.cranks = 1;
  EXPECT_DOUBLE_EQ(crankError(fit, -200.0), 0.3);
}

TEST(PredictCranking, EqualsABruteForceSimulation) {
  const FittedModel model = driveModel();
  for (double i_load : {0.0, -25.0, -60.0})
    for (double t_stop : {0.0, 5.0, 60.0})
      for (double t_cranking : {0.1, 1.0, 3.0}) {
        CrankingQuery query = usualQuery();
        query.i_load = i_load;
        query.t_stop = t_stop;
        query.t_cranking = t_cranking;
        EXPECT_NEAR(predictCranking(model, query, 1000.0).u_min->value, byBruteForce(model, query),
                    1e-9);
      }
}

TEST(PredictCranking, BeyondOnePercentOfTheChargeTheOpenCircuitVoltageFalls) {
  const FittedModel model = driveModel();
  CrankingQuery query = usualQuery();
  query.i_load = -60.0;
  query.t_stop = 60.0;  // 1 Ah: 2 % of 50 Ah
  const Interval constant = *predictCranking(model, query, 1000.0).u_min,
                 fallen = *predictCranking(model, query, 50.0).u_min;
  EXPECT_NEAR(fallen.value, constant.value - 0.012, 1e-9);
  EXPECT_GT(fallen.upper - fallen.lower, constant.upper - constant.lower);
}

TEST(PredictCranking, FindsTheMinimumAtTheBeginningWhenTheBatteryRecoversDuringTheCrank) {
  // After -300 A the state lies below what -1 A settles at: u_c2 rises during the "crank".
  FittedModel model = driveModel();
  model.state.states[0] = test::settledOverpotential(model.fit.parameters, -300.0);
  CrankingQuery query = usualQuery();
  query.t_stop = 0.0;
  query.i_cranking = -1.0;
  query.t_cranking = 10.0;
  EXPECT_NEAR(predictCranking(model, query).u_min->value, byBruteForce(model, query), 1e-3);
}

TEST(PredictCranking, ALongerStopAndAStrongerCrankNeverRaiseTheMinimumOfARestedBattery) {
  FittedModel model = driveModel();
  model.state.states[0] = 0.0;
  double before = 100.0;
  for (double t_stop : {0.0, 1.0, 10.0, 60.0, 600.0}) {
    CrankingQuery query = usualQuery();
    query.t_stop = t_stop;
    const double u = predictCranking(model, query).u_min->value;
    EXPECT_LE(u, before);
    before = u;
  }
}

TEST(PredictCranking, TheIntervalHoldsTheTruthInNineOfTenDrives) {
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const FittedModel model = driveModel(seed);
    const auto u = predictCranking(model, usualQuery()).u_min;
    FittedModel truth = model;
    truth.fit.parameters = test::drivenBattery();
    const double expected = predictCranking(truth, usualQuery()).u_min->value;
    inside += expected >= u->lower && expected <= u->upper;
  }
  EXPECT_GE(inside, 84);  // 90 less two binomial standard deviations
}

TEST(PredictCranking, SaysWhetherTheCrankHolds) {
  CrankingQuery query = usualQuery();
  query.u_required = 7.2;
  EXPECT_TRUE(*predictCranking(driveModel(), query).capable);
  query.u_required = 12.0;
  EXPECT_FALSE(*predictCranking(driveModel(), query).capable);
}

TEST(PredictCranking, WithoutALimitNothingHoldsAndTheMessageSaysWhy) {
  for (const double left_out : {0.0, std::nan("")}) {
    CrankingQuery query = usualQuery();
    query.t_cranking = query.u_required.emplace(left_out);
    query = asked(query);
    EXPECT_EQ(query.t_cranking, 1.0);
    const CrankingAnswer answer = predictCranking(driveModel(), query);
    EXPECT_FALSE(answer.capable.has_value());
    EXPECT_NE(answer.message.find("no u_required was given"), std::string::npos) << answer.message;
  }
}

TEST(PredictCranking, RefusesEveryImpossibleQueryAndNamesTheInput) {
  const FittedModel model = driveModel();
  const auto refused = [&](auto change, const std::string& name) {
    CrankingQuery query = usualQuery();
    change(query);
    const CrankingAnswer answer = predictCranking(model, query);
    EXPECT_EQ(answer.code, AnswerCode::kInvalidQuery) << name;
    EXPECT_FALSE(answer.u_min.has_value()) << name;
    EXPECT_FALSE(answer.valid) << name;
    EXPECT_NE(answer.message.find(name), std::string::npos) << answer.message;
  };
  const double nan = std::nan("");
  refused([&](auto& q) { q.i_load = nan; }, "i_load");
  refused([&](auto& q) { q.t_stop = nan; }, "t_stop");
  refused([&](auto& q) { q.i_cranking = nan; }, "i_cranking");
  refused([&](auto& q) { q.t_cranking = nan; }, "t_cranking");
  refused([&](auto& q) { q.u_required = nan; }, "u_required");
  refused([&](auto& q) { q.u_required = 0.0; }, "u_required");
  refused([&](auto& q) { q.i_cranking = 200.0; }, "i_cranking");
  refused([&](auto& q) { q.i_load = 5.0; }, "i_load");
  refused([&](auto& q) { q.t_stop = -1.0; }, "t_stop");
  refused([&](auto& q) { q.t_stop = 365.0 * 86400.0; }, "t_stop");
  refused([&](auto& q) { q.t_cranking = 0.0; }, "t_cranking");
  refused([&](auto& q) { q.i_cranking = -std::numeric_limits<double>::infinity(); }, "i_cranking");
}

TEST(PredictCranking, NamesAllFaultsOfAQueryAtOnce) {
  CrankingQuery query = usualQuery();
  query.i_load = 3.0;
  query.t_stop = -1.0;
  const std::string faults = join(faultsOf(query), "; ");
  EXPECT_NE(faults.find("i_load"), std::string::npos);
  EXPECT_NE(faults.find("t_stop"), std::string::npos);
}

TEST(PredictCranking, IsNotValidBeyondWhatTheWindowExcited) {
  CrankingQuery query = usualQuery();
  query.i_cranking = -900.0;
  const CrankingAnswer answer = predictCranking(driveModel(), query);
  EXPECT_EQ(answer.code, AnswerCode::kExtrapolation);
  EXPECT_FALSE(answer.valid);
  EXPECT_TRUE(answer.u_min.has_value());
}

TEST(PredictCranking, IsNotValidWhenTheStopTakesMoreThanTwoPercentOfTheCharge) {
  CrankingQuery query = usualQuery();
  query.t_stop = 240.0;  // 25 A for 240 s: 1.67 Ah of 50 Ah
  EXPECT_FALSE(predictCranking(driveModel(), query, 50.0).valid);
  EXPECT_TRUE(predictCranking(driveModel(), query, 100.0).valid);
}

TEST(PredictCranking, HasNoAnswerFromAModelThatCannotBeUsed) {
  FittedModel model = driveModel();
  model.fit.status = FitStatus::kNotExcited;
  const CrankingAnswer answer = predictCranking(model, usualQuery());
  EXPECT_EQ(answer.code, AnswerCode::kNoModel);
  EXPECT_FALSE(answer.u_min.has_value());
}

TEST(PredictCranking, ProfilesEqualTheHeldCurrentsTheyStandFor) {
  const FittedModel model = driveModel();
  const CrankingQuery held = usualQuery();
  CrankingQuery profiled = held;
  profiled.i_load = profiled.t_stop = profiled.i_cranking = profiled.t_cranking = std::nan("");
  profiled.load = {{0.0, 30.0}, {-25.0, -25.0}};
  profiled.crank = {{0.0, 0.8}, {-200.0, -200.0}};
  const CrankingAnswer of_held = predictCranking(model, held),
                       of_profile = predictCranking(model, profiled);
  ASSERT_TRUE(of_profile.u_min) << of_profile.message;
  EXPECT_NEAR(of_profile.u_min->value, of_held.u_min->value, 1e-9);
  EXPECT_NEAR(of_profile.u_min->lower, of_held.u_min->lower, 1e-9);
  EXPECT_EQ(of_profile.valid, of_held.valid);
  EXPECT_EQ(of_profile.capable, of_held.capable);
}

TEST(PredictCranking, AProfileThatBeginsLateIsHeldFromTheBeginning) {
  const FittedModel model = driveModel();
  CrankingQuery held = usualQuery(), late = usualQuery();
  late.load = {{20.0, 30.0}, {-25.0, -25.0}};
  EXPECT_NEAR(predictCranking(model, late).u_min->value, predictCranking(model, held).u_min->value,
              1e-9);
  late.load.current = {-100.0, -100.0};  // 30 s of it: 0.83 Ah
  EXPECT_TRUE(predictCranking(model, late, 50.0).valid);
  EXPECT_FALSE(predictCranking(model, late, 40.0).valid);
}

TEST(PredictCranking, AnInrushMakesTheMinimumEarly) {
  const FittedModel model = driveModel();
  CrankingQuery inrush = usualQuery();
  inrush.crank = {{0.0, 0.05, 0.1, 0.8}, {-260.0, -260.0, -160.0, -160.0}};
  CrankingQuery plateau = usualQuery();
  plateau.i_cranking = -160.0;
  EXPECT_LT(predictCranking(model, inrush).u_min->value,
            predictCranking(model, plateau).u_min->value - 0.3);
}

TEST(PredictCranking, RefusesProfilesWithAFaultAndSaysWhich) {
  const auto fault = [](auto change) {
    CrankingQuery query = usualQuery();
    change(query);
    return join(faultsOf(query), "; ");
  };
  EXPECT_NE(fault([](auto& q) {
              q.load = {{0.0, 1.0}, {-5.0}};
            }).find("load has 2 times"),
            std::string::npos);
  EXPECT_NE(fault([](auto& q) {
              q.crank = {{0.0, 61.0}, {-200.0, -200.0}};
            }).find("up to 60"),
            std::string::npos);
  EXPECT_NE(fault([](auto& q) {
              q.crank = {{0.0, 1.0}, {0.0, 5.0}};
            }).find("below 0"),
            std::string::npos);
}

}  // namespace
}  // namespace battery_sof
