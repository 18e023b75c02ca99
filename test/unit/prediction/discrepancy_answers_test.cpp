#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimation/identification.hpp"
#include "prediction/questions.hpp"
#include "prediction/scores.hpp"
#include "report/model_yaml.hpp"
#include "support/drive_with_discrepancy.hpp"

namespace battery_sof {
namespace {

using namespace test;
using ::testing::HasSubstr;

/// A battery with a memory of charging, and the model that estimated it from two thirds of the
/// recording.
struct Learnt {
  Series series = withMemoryOfCharging(600.0);
  IndexRange window = {0, 2 * series.size() / 3}, later = {window.last, series.size()};
  FittedModel base = identify(series, window);
  FittedModel model;

  Learnt() {
    IdentifyOptions options;
    options.effects = {kDiscrepancyEffect};
    options.discrepancy = discrepancyLearntFrom(series, window.last);
    options.more_starts = 0;
    model = identify(series, window, options);
  }
};

const Learnt& estimated() {
  static const Learnt once;
  return once;
}

double rmseOf(const FittedModel& model) {
  const std::vector<double> predicted =
      predictSeries(model, estimated().series, estimated().later).voltage;
  double sum = 0.0;
  for (std::size_t n = 0; n < predicted.size(); ++n)
    sum += std::pow(estimated().series.voltage[estimated().later.first + n] - predicted[n], 2);
  return std::sqrt(sum / static_cast<double>(predicted.size()));
}

std::string errorOf(const std::string& text) {
  try {
    parseModelYaml(text, "model.yaml");
  } catch (const ModelFileError& error) {
    return error.what();
  }
  return "";
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(DiscrepancyAnswers, WhatComesAfterTheWindowIsPredictedBetter) {
  EXPECT_LT(rmseOf(estimated().model), 0.5 * rmseOf(estimated().base));
}

TEST(DiscrepancyAnswers, FactorsAreFittedNearWhatWasLearnt) {
  for (const ParameterEstimate& estimate : estimated().model.fit.estimates)
    if (estimate.name == "discrepancy_acceptance") {
      EXPECT_NEAR(1.0, estimate.value, 0.3);
      EXPECT_TRUE(estimate.std);
      return;
    }
  FAIL() << "no factor of acceptance";
}

TEST(DiscrepancyAnswers, AModelFileGivesTheSameAnswers) {
  const FittedModel& model = estimated().model;
  const FittedModel back = parseModelYaml(modelYaml(model), "model.yaml");
  EXPECT_EQ(modelYaml(back), modelYaml(model));
  const CrankingQuery crank{-25.0, 20.0, -200.0, 0.5, 7.2};
  EXPECT_NEAR(predictCranking(model, crank).u_min->value, predictCranking(back, crank).u_min->value,
              1e-9);
  EXPECT_NEAR(predictCranking(model, crank).u_min->lower, predictCranking(back, crank).u_min->lower,
              1e-6);
  EXPECT_NEAR(rmseOf(model), rmseOf(back), 1e-9);
}

TEST(DiscrepancyAnswers, AModelFileWhoseForceIsDamagedIsRefusedByField) {
  const std::string good = modelYaml(estimated().model);
  EXPECT_THAT(errorOf(with(good, "kind: charge_memory", "kind: perpetual_memory")),
              HasSubstr("kind is \"perpetual_memory\", expected one of charge_memory"));
  EXPECT_THAT(errorOf(with(good, "\ndiscrepancy:\n", "\nforce_of_habit:\n")),
              HasSubstr("effects cannot be used"));
  EXPECT_THAT(errorOf(with(good, "  circuit: [", "  circuit: [1, ")),
              HasSubstr("discrepancy.circuit has 7 numbers, expected 6"));
  EXPECT_THAT(errorOf(with(good, "  regressor_memory: [", "  regressor_memory: [1, ")),
              HasSubstr("state.regressor_memory has"));
  EXPECT_THAT(errorOf(with(good, "  factor_std:\n", "  factor_std:\n    ageing: -1\n")),
              HasSubstr("deviation must be finite and at least 0"));
}

TEST(DiscrepancyAnswers, ACrankFarBeyondWhatWasLearntOnIsNotVouchedForAndWider) {
  FittedModel narrow = estimated().model;
  auto discrepancy = std::make_shared<DiscrepancyModel>(*narrow.fit.discrepancy);
  for (Eigen::Index k = 0; k < discrepancy->weight.size(); ++k)
    if (discrepancy->regressors[static_cast<std::size_t>(k)].kind == RegressorKind::kCompressed) {
      discrepancy->upper[k] = std::max(discrepancy->lower[k], 0.0);
      discrepancy->lower[k] = std::min(discrepancy->upper[k], -0.1);
      discrepancy->weight[k] = 0.05;
    }
  narrow.fit.discrepancy = discrepancy;
  FittedModel wide = narrow;
  auto unbounded = std::make_shared<DiscrepancyModel>(*discrepancy);
  unbounded->lower.setConstant(-1e9);
  unbounded->upper.setConstant(1e9);
  wide.fit.discrepancy = unbounded;
  const CrankingQuery crank{-25.0, 20.0, -200.0, 0.5, 7.2};
  const CrankingAnswer inside = predictCranking(wide, crank),
                       outside = predictCranking(narrow, crank);
  EXPECT_TRUE(inside.valid) << inside.message;
  EXPECT_FALSE(outside.valid);
  EXPECT_EQ(AnswerCode::kExtrapolation, outside.code);
  EXPECT_THAT(outside.message, HasSubstr("the discrepancy is held at the end of its range"));
  EXPECT_GT(outside.u_min->upper - outside.u_min->lower, inside.u_min->upper - inside.u_min->lower);
  const StopTimeAnswer stop = predictStopTime(narrow, {-25.0, -200.0, 0.5, 7.2});
  EXPECT_THAT(stop.message, HasSubstr("held at the end of its range"));
}

TEST(DiscrepancyAnswers, AChargeIsAnsweredByTheSameForce) {
  const ChargeAcceptanceQuery query{14.2, 10.0, 300.0};
  const ChargeAcceptanceAnswer with_discrepancy = predictChargeAcceptance(estimated().model, query),
                               without = predictChargeAcceptance(estimated().base, query);
  ASSERT_TRUE(with_discrepancy.i_boost && without.i_boost);
  Simulation after = simulationOf(estimated().model);
  double charge = 0.0;
  for (int n = 0; n < 1000; ++n) charge += 0.01 * after.advanceAtVoltage(14.2, 0.01, 300.0);
  EXPECT_NEAR(charge / 10.0, with_discrepancy.i_boost->value,
              0.02 * with_discrepancy.i_boost->value);
}

TEST(DiscrepancyAnswers, ARestedModelHasForgottenWhatDroveIt) {
  const FittedModel rest = rested(estimated().model);
  EXPECT_EQ(rest.state.regressor_memory.size(), estimated().model.fit.discrepancy->memorySize());
  EXPECT_NE(rest.state.regressor_memory, estimated().model.state.regressor_memory);
  EXPECT_TRUE(predictCranking(rest, {-25.0, 20.0, -200.0, 0.5, 7.2}).u_min);
}

}  // namespace
}  // namespace battery_sof
