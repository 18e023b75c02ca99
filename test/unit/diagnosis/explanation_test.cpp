#include "diagnosis/explanation_fits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "support/composed.hpp"

namespace battery_sof {
namespace {

using namespace test;

const std::vector<std::string> kSome = {"charge_acceptance", "ocv_soc", "time_skew"};

/// Four minutes at 10 Hz with a millivolt of white noise, of a composition.
Series inputsOf(const std::vector<std::string>& effects, const std::string& parameter = "",
                double value = 0.0) {
  const BatteryModel model(effects);
  Eigen::VectorXd parameters = typicalPoint(model);
  if (!parameter.empty()) parameters[*model.parameterRow(parameter)] = value;
  Series series = test::answered(drivenBattery(), dataSetOneCurrent(240.0, 0.1, 8), 0.1, 0.0, 8);
  series.voltage =
      voltages(model, pointOf(model, parameters), inputSequence(series, whole(series)));
  addNoise(series, 0.0, 0.001, 8);
  return series;
}

/// The base circuit with the square root of what ten seconds of charging leave [V]: of no equation.
Series driveOfNoEquation() {
  Series series = inputsOf({});
  double memory = 0.0;
  for (std::size_t n = 1; n < series.size(); ++n) {
    memory += -std::expm1(-0.01) * (std::max(series.current[n], 0.0) - memory);
    series.voltage[n] += 0.02 * std::sqrt(memory);
  }
  return series;
}

std::unique_ptr<ExplanationFits> fitsTo(const Series& series) {
  const InputSequence inputs = inputSequence(series, whole(series));
  const CompositionPoint base{typicalPoint(BatteryModel()), BatteryModel().restState()};
  return std::make_unique<ExplanationFits>(inputs, base, DiagnoseOptions());
}

Explanation explained(const Series& series, const std::vector<std::string>& ids,
                      const std::vector<std::string>& given = {}) {
  DiagnoseOptions options;
  options.given = given;
  return explain(*fitsTo(series), ids, options);
}

TEST(HalfSamples, AreEveryTwoQuartersOfTheRows) {
  const std::unique_ptr<ExplanationFits> fits = fitsTo(inputsOf({}));
  const ExplanationSums all = fits->sumsOf(fits->baseState(), true);
  const std::vector<LinearProblem> halves = fits->halfSamples(all);
  ASSERT_EQ(6u, halves.size());
  LinearProblem sum = all.problem;
  for (const LinearProblem& half : halves) {
    EXPECT_NEAR(all.problem.rows / 2.0, half.rows, 1.0);
    sum.products += half.products;
    sum.targets += half.targets;
    sum.square += half.square;
    sum.rows += half.rows;
  }
  EXPECT_EQ(4.0 * all.problem.rows, sum.rows);
  EXPECT_NEAR(4.0 * all.problem.square, sum.square, 1e-12 * sum.square);
  EXPECT_LT((sum.products - 4.0 * all.problem.products).norm(), 1e-9 * sum.products.norm());
  EXPECT_LT((sum.targets - 4.0 * all.problem.targets).norm(), 1e-9 * sum.targets.norm());
}

TEST(HalfSamples, OfASumWithoutMechanismsAreThoseOfTheStateAlone) {
  const std::unique_ptr<ExplanationFits> fits = fitsTo(inputsOf({}));
  ExplanationState state = fits->baseState();
  fits->evaluateEvidence(state);
  const LinearProblem all = fits->sumsOf(state, true).problem;
  EXPECT_NEAR(state.fit.evidence, fits->fitOf(fits->restricted(all, {})).evidence, 1e-6);
  const ExplanationState acid = fits->withRegressors(state, Mechanism::kAcid);
  EXPECT_NEAR(acid.fit.evidence, fits->fitOf(fits->restricted(all, {Mechanism::kAcid})).evidence,
              1e-6);
}

TEST(Explain, ALawNearAnEquationIsThatEquationThoughRegressorsFitTheSeenRowsCloser) {
  Series series = inputsOf({"ocv_soc"}, "ocv_slope", 0.2);
  double charge = 0.0;
  for (std::size_t n = 1; n < series.size(); ++n) {
    charge += 0.1 * series.current[n];
    series.voltage[n] += 0.003 * std::sin(charge / 200.0);
  }
  const Explanation found = explained(series, kSome);
  ASSERT_FALSE(found.terms.empty());
  EXPECT_EQ("ocv_soc", found.terms.front().member);
}

TEST(Explain, TheBaseCircuitsOwnVoltageNeedsNoExplanation) {
  const Explanation found = explained(baseDrive(3), kSome);
  EXPECT_TRUE(found.terms.empty());
  EXPECT_TRUE(found.model.effects().empty());
  EXPECT_EQ(found.base_evidence, found.evidence);
  EXPECT_NEAR(0.002 / std::sqrt(10.0), found.unexplained.noise, 1e-4);
  EXPECT_LT(found.unexplained.rmse, 0.001);
}

TEST(Explain, AnOpenCircuitVoltageThatFollowsTheChargeIsExplainedByItself) {
  const Explanation found = explained(inputsOf({"ocv_soc"}, "ocv_slope", 0.2), kSome);
  ASSERT_EQ(1u, found.terms.size());
  const SelectedTerm& one = found.terms.front();
  EXPECT_EQ("ocv_soc", one.member);
  EXPECT_EQ(Mechanism::kOpenCircuit, one.mechanism);
  EXPECT_GT(one.gain, kMinGain);
  ASSERT_EQ(6u, one.half_gains.size());
  for (const double gain : one.half_gains) EXPECT_GT(gain, 0.0) << "half of the rows";
  EXPECT_NEAR(0.2, found.point.parameters[*found.model.parameterRow("ocv_slope")], 0.02);
  EXPECT_GT(found.evidence, found.base_evidence);
}

TEST(Explain, ALawOfNoEquationIsExplainedByItsFamily) {
  const Explanation found = explained(driveOfNoEquation(), kSome);
  ASSERT_FALSE(found.terms.empty());
  EXPECT_EQ("acceptance", mechanismId(found.terms.front().mechanism));
}

TEST(Explain, WithoutEquationsAFamilysColumnsStandForThemselves) {
  const Explanation found = explained(driveOfNoEquation(), {});
  ASSERT_FALSE(found.terms.empty());
  EXPECT_EQ("acceptance", mechanismId(found.terms.front().mechanism));
  for (const SelectedTerm& one : found.terms) EXPECT_EQ("", one.member);
  EXPECT_TRUE(found.model.effects().empty());
  EXPECT_LT(found.unexplained.noise, 0.2 * found.terms.front().rms);
}

TEST(Explain, WhatIsGivenIsTakenAndNothingElseIsLookedFor) {
  const Explanation found =
      explained(inputsOf({"ocv_soc"}, "ocv_slope", 0.2), kSome, {"acid_transport"});
  EXPECT_EQ((std::vector<std::string>{"acid_transport"}), found.model.effects());
  ASSERT_EQ(1u, found.terms.size());
  EXPECT_EQ("acid_transport", found.terms.front().member);
}

TEST(Explain, TheSameSetHasOneScoreByAnyPath) {
  const BatteryModel model({"charge_acceptance", "ocv_soc"});
  Eigen::VectorXd parameters = typicalPoint(model);
  parameters[*model.parameterRow("ocv_slope")] = 0.2;
  Series series = test::answered(drivenBattery(), dataSetOneCurrent(240.0, 0.1, 8), 0.1, 0.0, 8);
  series.voltage =
      voltages(model, pointOf(model, parameters), inputSequence(series, whole(series)));
  addNoise(series, 0.0, 0.001, 8);
  const Explanation one = explained(series, kSome, {"charge_acceptance", "ocv_soc"}),
                    other = explained(series, kSome, {"ocv_soc", "charge_acceptance"}),
                    found = explained(series, kSome);
  EXPECT_EQ(one.evidence, other.evidence);
  ASSERT_EQ(2u, found.terms.size());
  for (const std::string& id : one.model.effects())
    EXPECT_TRUE(std::any_of(found.terms.begin(), found.terms.end(), [&](const SelectedTerm& part) {
      return part.member == id;
    })) << id;
  EXPECT_NEAR(one.evidence, found.evidence, 0.5);
}

TEST(Explain, LeastStrengthsAreToldOfWhatIsNotInIt) {
  const Explanation found =
      explained(inputsOf({"ocv_soc"}, "ocv_slope", 0.2), {"ocv_soc", "current_offset"});
  ASSERT_EQ(1u, found.detection_limits.size());
  const DetectionLimit& least = found.detection_limits.front();
  EXPECT_EQ("current_offset", least.id);
  EXPECT_EQ("A", least.unit);
  EXPECT_GT(std::abs(least.typical), 0.0);
}

TEST(Explain, TheSameDataHaveOneExplanationBitForBit) {
  const Series series = driveOfNoEquation();
  const Explanation one = explained(series, {"ocv_soc"}), other = explained(series, {"ocv_soc"});
  EXPECT_EQ(one.evidence, other.evidence);
  EXPECT_EQ(one.effective_sample_fraction, other.effective_sample_fraction);
  EXPECT_TRUE(one.point.parameters == other.point.parameters);
  EXPECT_TRUE(one.point.state == other.point.state);
  ASSERT_EQ(one.terms.size(), other.terms.size());
  for (std::size_t k = 0; k < one.terms.size(); ++k) {
    EXPECT_EQ(one.terms[k].member, other.terms[k].member);
    EXPECT_EQ(one.terms[k].gain, other.terms[k].gain);
    EXPECT_EQ(one.terms[k].rms, other.terms[k].rms);
  }
}

}  // namespace
}  // namespace battery_sof
