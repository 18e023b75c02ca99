#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "diagnosis/explanation_fits.hpp"
#include "diagnosis/score_selection.hpp"
#include "estimation/block_score.hpp"
#include "estimation/fit_window.hpp"
#include "estimation/identification.hpp"
#include "prediction/scores.hpp"
#include "support/sourced_drive.hpp"

/// Diagnoses of drives whose source controls the voltage.
namespace battery_sof {
namespace {

using namespace test;

constexpr std::size_t kSamples = 1500;

Series drawnFrom(const std::vector<std::string>& law) {
  return sourcedDrive(kSamples, typicalBattery(law), 11);
}

ScoreSelection selectedFrom(const Series& series, const std::vector<std::string>& ids,
                            const DiagnoseOptions& options = {}) {
  IdentifyOptions fit;
  fit.source = chargerControl(series).value();
  return selectByScore(series, {0, series.size()}, fit, ids, options);
}

std::vector<std::string> membersOf(const ScoreSelection& selection) {
  std::vector<std::string> ids;
  for (const SelectedTerm& term : selection.terms) ids.push_back(term.member);
  return ids;
}

TEST(SelectionByScore, TakesTheLawThatMadeTheDriveAndPredictsLeftOutBlocksByIt) {
  const ScoreSelection found =
      selectedFrom(drawnFrom({"fresh_sulphate"}), {"fresh_sulphate", "fast_arc", "current_gain"});
  EXPECT_EQ(std::vector<std::string>{"fresh_sulphate"}, membersOf(found));
  EXPECT_GT(found.score.equations.share(), found.circuit_score.equations.share() + 0.1);
  EXPECT_EQ(std::vector<std::string>{"fresh_sulphate"}, found.extended.fit.effects);
}

/// The circuit's fit takes in what the law does: a few steps from there promise less of the law than
/// of an effect that is none of it.
TEST(SelectionByScore, FindsChargeAcceptanceThatTheCircuitHasTakenIn) {
  DiagnoseOptions shallow;  // not a tenth of the capacity is moved
  shallow.capacity = 500.0;
  const ScoreSelection found =
      selectedFrom(sourcedDrive(kSamples, typicalBattery({"charge_acceptance"}), 12),
                   {"charge_acceptance", "second_electrode", "current_gain"}, shallow);
  ASSERT_FALSE(found.terms.empty());
  EXPECT_EQ("charge_acceptance", found.terms.front().member);
  EXPECT_GT(found.score.equations.share(), found.circuit_score.equations.share() + 0.3);
}

TEST(SelectionByScore, TakesNothingWhereTheCircuitItselfMadeTheDrive) {
  const ScoreSelection found =
      selectedFrom(drawnFrom({}), {"fast_arc", "current_gain", "ocv_soc", "charge_transfer"});
  EXPECT_TRUE(found.terms.empty()) << membersOf(found).front();
  EXPECT_EQ(found.circuit.fit.parameters.r_discharge, found.extended.fit.parameters.r_discharge);
}

TEST(SelectionByScore, WhatIsGivenIsFittedAsItIsAndIsNoOtherModel) {
  const Series series = drawnFrom({"fresh_sulphate"});
  DiagnoseOptions gain, offset;
  gain.given = {"current_gain"};
  offset.given = {"current_offset"};
  const ScoreSelection one = selectedFrom(series, {}, gain),
                       other = selectedFrom(series, {}, offset);
  EXPECT_EQ(std::vector<std::string>{"current_gain"}, membersOf(one));
  EXPECT_EQ(std::vector<std::string>{"current_offset"}, membersOf(other));
  EXPECT_NE(one.score.equations.share(), other.score.equations.share());
}

TEST(SelectionByScore, FitsWhatIsGivenFromTheCircuitsOptimumAlone) {
  const Series series = sourcedDrive(900, typicalBattery({"fresh_sulphate"}), 5);
  DiagnoseOptions given;
  given.given = {"contact_resistance"};
  const ScoreSelection found = selectedFrom(series, {}, given);
  IdentifyOptions fit;
  fit.source = chargerControl(series).value();
  fit.effects = given.given;
  fit.starts = startsInLarger(BatteryModel(), optimumOf(found.circuit), BatteryModel(fit.effects));
  const auto missed = [&](const FittedModel& model) {
    return equationErrors(model, series, {0, series.size()}, fit).norm();
  };
  const double from_typical_too = missed(identify(series, {0, series.size()}, fit));
  fit.only_starts = true;
  const double from_the_circuit = missed(identify(series, {0, series.size()}, fit));
  EXPECT_GT(from_the_circuit, 1.05 * from_typical_too);  // the two differ on this drive
  EXPECT_NEAR(missed(found.extended), from_the_circuit, 1e-9 * from_the_circuit);
}

TEST(SelectionByScore, IsTheSameForAnyNumberOfThreads) {
  const Series series = drawnFrom({"fresh_sulphate"});
  DiagnoseOptions two;
  two.threads = 2;
  const ScoreSelection one = selectedFrom(series, {"fresh_sulphate", "fast_arc"}),
                       same = selectedFrom(series, {"fresh_sulphate", "fast_arc"}, two);
  EXPECT_EQ(membersOf(one), membersOf(same));
  EXPECT_EQ(one.score.with_regression.relative, same.score.with_regression.relative);
}

/// The circuit of a diagnosis and what `sof identify --effects none` and `sof predict --mode mixed`
/// give over the same rows are one number.
TEST(DiagnosisOfARegulatedVoltage, HasTheCircuitOfIdentify) {
  Recording recording;
  recording.series = drawnFrom({"fresh_sulphate"});
  const Diagnosis diagnosis = diagnose(recording);
  const Series& series = recording.series;
  FitRequest request;
  request.from = diagnosis.fit.train.from;
  request.to = diagnosis.fit.train.to;
  FittedModel circuit = fitPlanned(series, planFit(series, request));
  const IndexRange holdout = samplesBetween(series, diagnosis.fit.holdout.from, std::nullopt);
  const auto scores = predictRange(circuit, series, holdout, PredictionMode::kMixed).report;
  ASSERT_TRUE(scores.both_ways && diagnosis.fit.base_holdout.share_percent);
  EXPECT_NEAR(*scores.both_ways->mixed.share_percent, *diagnosis.fit.base_holdout.share_percent,
              1e-6);
  EXPECT_GT(*diagnosis.fit.extended_holdout.share_percent,
            *diagnosis.fit.base_holdout.share_percent);
  ASSERT_FALSE(diagnosis.effects.empty());
  EXPECT_EQ("fresh_sulphate", diagnosis.effects.front().id);
}

/// Ten minutes between samples: forward sensitivities of the implicit steps grow without a bound
/// there, and no step could be solved for.
TEST(RegulatedVoltage, DerivativesThatDivergeAreNoLinearization) {
  Series series = sourcedDrive(kSamples, knownModel({"fresh_sulphate"}), 11);
  for (double& time : series.time) time *= 600.0;
  const InputSequence inputs =
      inputSequence(series, {0, series.size()}, {}, std::vector<char>(series.size(), 1));
  const auto fits = std::make_unique<ExplanationFits>(
      inputs, CompositionPoint{typicalPoint(BatteryModel()), BatteryModel().restState()},
      DiagnoseOptions());
  ExplanationState state = fits->baseState();
  EXPECT_TRUE(fits->linearize(state));
  state.model = BatteryModel({"fresh_sulphate"});
  state.coordinates = fits->coordinatesOf(state.model);
  state.point = embedded(BatteryModel(), state.point, state.model);
  state.point.parameters << 0.0103, 0.0085, 108.0, 7.28, 13.155, 1.0, 2.942, 9.683, 0.3, 1.4713,
      16.218, 0.02553, 5.246;
  state.point.state << 0.6, 1.0, 18.0;
  EXPECT_FALSE(fits->linearize(state));
  EXPECT_LT(state.error.cwiseAbs().maxCoeff(), 100.0);  // a voltage there is

  // What is left without a part begins at the base circuit then.
  const CompositionPoint there = state.point;
  state.members = {"fresh_sulphate", "ocv_soc"};
  state.model = BatteryModel(state.members);
  state.coordinates = fits->coordinatesOf(state.model);
  state.point = embedded(BatteryModel({"fresh_sulphate"}), there, state.model);
  state.evidence = 1e9;
  const ExplanationState without = fits->withoutMembers(state, {"ocv_soc"});
  EXPECT_TRUE(std::isfinite(without.evidence));
  EXPECT_LT(without.evidence, 1e6);
}

}  // namespace
}  // namespace battery_sof
