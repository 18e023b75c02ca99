#include "diagnosis/verdict.hpp"

#include <gtest/gtest.h>

#include <set>

#include "diagnosis/model_selection.hpp"

namespace battery_sof {
namespace {

SelectedTerm effect(const std::string& id, const std::vector<std::string>& indistinguishable = {}) {
  return {mechanismOf(id), id, 100.0, 0.01, indistinguishable, 1.0};
}

SelectedTerm columnsOf(Mechanism mechanism) { return {mechanism, "", 100.0, 0.01, {}, 1.0}; }

Verdict verdictOf(const std::vector<SelectedTerm>& terms,
                  const std::vector<std::string>& faults = {}, const Unexplained& rest = {}) {
  return judge(terms, faults, rest);
}

Unexplained discrepancy() {
  Unexplained rest;
  rest.has_discrepancy = true;
  return rest;
}

TEST(Verdict, NothingExplainedAndNothingLeftIsNoMismatch) {
  EXPECT_EQ(Verdict::kNoMismatch, verdictOf({}));
}

TEST(Verdict, NothingExplainedButSomethingLeftIsUnknown) {
  EXPECT_EQ(Verdict::kUnexplained, verdictOf({}, {}, discrepancy()));
  Unexplained tone, large;
  tone.is_tone = true;
  EXPECT_EQ(Verdict::kUnexplained, verdictOf({}, {}, tone));
  large.rmse = 1.01 * kPlausible;
  EXPECT_EQ(Verdict::kUnexplained, verdictOf({}, {}, large));
  large.rmse = 0.99 * kPlausible;
  EXPECT_EQ(Verdict::kNoMismatch, verdictOf({}, {}, large));
}

TEST(Verdict, AFamilyThatNoEffectStandsForIsUnknown) {
  EXPECT_EQ(Verdict::kUnexplained, verdictOf({columnsOf(Mechanism::kAcceptance)}));
  EXPECT_EQ(Verdict::kUnexplained,
            verdictOf({columnsOf(Mechanism::kAcceptance), effect("ocv_soc")}));
}

TEST(Verdict, AnEffectThatExplainsMoreThanAFamilyBesideItIsNamed) {
  EXPECT_EQ(Verdict::kEffect, verdictOf({effect("ocv_soc"), columnsOf(Mechanism::kAcceptance)}));
}

TEST(Verdict, OneEffectIsNamedAndTwoAreSeveral) {
  EXPECT_EQ(Verdict::kEffect, verdictOf({effect("ocv_soc")}));
  EXPECT_EQ(Verdict::kSeveral, verdictOf({effect("ocv_soc"), effect("cpe2")}));
}

TEST(Verdict, AnEffectThatAnotherCouldReplaceIsAmbiguous) {
  EXPECT_EQ(Verdict::kAmbiguous, verdictOf({effect("acid_transport", {"high_rate_depletion"})}));
  EXPECT_EQ(Verdict::kAmbiguous,
            verdictOf({effect("ocv_soc"), effect("acid_transport", {"high_rate_depletion"})}));
}

TEST(Verdict, AnEffectOfTheInstrumentsAloneIsASensorFault) {
  EXPECT_EQ(Verdict::kSensorFault, verdictOf({effect("time_skew")}));
  EXPECT_EQ(Verdict::kSensorFault, verdictOf({effect("time_skew"), effect("current_offset")}));
  EXPECT_EQ(Verdict::kSeveral, verdictOf({effect("time_skew"), effect("ocv_soc")}));
}

TEST(Verdict, FaultsOfTheInstrumentsAreNamedWhenNothingElseIs) {
  EXPECT_EQ(Verdict::kSensorFault, verdictOf({}, {"clipping"}));
  EXPECT_EQ(Verdict::kSensorFault, verdictOf({}, {"clipping"}, discrepancy()));
  EXPECT_EQ(Verdict::kEffect, verdictOf({effect("cpe2")}, {"clipping"}));
}

TEST(Verdict, FaultsOfTheInstrumentsHideNeitherAToneNorMoreThanTheyLeave) {
  Unexplained tone, more;
  tone.is_tone = true;
  more.rmse = 0.02;
  for (const Unexplained& rest : {tone, more})
    EXPECT_EQ(Verdict::kUnexplained, verdictOf({}, {"quantisation"}, rest));
}

TEST(Verdict, WhatLooksLikeTheInstrumentsIsTheirFaultOnlyWhereTheyHaveOne) {
  EXPECT_EQ(Verdict::kUnexplained, verdictOf({columnsOf(Mechanism::kInstrument)}));
  EXPECT_EQ(Verdict::kSensorFault,
            verdictOf({columnsOf(Mechanism::kInstrument)}, {"quantisation"}));
}

/// Whether a summary has a piece of text.
bool says(const Diagnosis& diagnosis, const std::string& text) {
  return summaryOf(diagnosis).find(text) != std::string::npos;
}

/// One of each verdict, with long names and numbers.
Diagnosis judgedAs(Verdict verdict) {
  Diagnosis diagnosis;
  diagnosis.verdict = verdict;
  if (!hasNoEquation(verdict) && verdict != Verdict::kNoMismatch) {
    for (const char* id : {"acid_transport", "second_electrode", "fast_arc", "sensor_lag"}) {
      diagnosis.effects.emplace_back();
      diagnosis.effects.back().id = id;
    }
    if (verdict == Verdict::kEffect || verdict == Verdict::kSensorFault)
      diagnosis.effects.resize(1);
  }
  if (verdict != Verdict::kNoMismatch && verdict != Verdict::kUnexplained) {
    diagnosis.mechanism = Mechanism::kOpenCircuit;
    diagnosis.probability = 0.6;
    diagnosis.mechanisms = {{Mechanism::kOpenCircuit, 0.6}, {Mechanism::kSideReactions, 0.21}};
  }
  diagnosis.regimes = {{"high-voltage charge", "mean", 5, 0.899, 0.864, 0.933, 0.06, false}};
  diagnosis.fit.base_holdout.rmse = 0.3;
  diagnosis.fit.extended_holdout.rmse = 0.1;
  return diagnosis;
}

TEST(Verdict, OfAnEquationIsAmbiguousWhereAnotherMechanismIsLikelier) {
  const SelectedTerm equation{Mechanism::kAcid, "acid_transport", 20.0, 0.01, {}, 0.3},
      regressors{Mechanism::kInstrument, "", 20.0, 0.01, {}, 0.3};
  EXPECT_EQ(Verdict::kEffect, withMechanism(Verdict::kEffect, {equation}, Mechanism::kAcid));
  EXPECT_EQ(Verdict::kAmbiguous, withMechanism(Verdict::kEffect, {equation}, Mechanism::kAgeing));
  EXPECT_EQ(Verdict::kMechanism, withMechanism(Verdict::kUnexplained, {}, Mechanism::kAgeing));
  EXPECT_EQ(Verdict::kSensorFault,
            withMechanism(Verdict::kSensorFault, {regressors}, Mechanism::kStructure))
      << "regressors are no equation that a headline could name";
}

TEST(Terms, OfAnotherMechanismThatGainLessThanATenthOfTheLargestAreNotNamed) {
  const auto left = [](const std::vector<std::pair<Mechanism, double>>& given) {
    std::vector<SelectedTerm> terms;
    for (const auto& [mechanism, gain] : given)
      terms.push_back({mechanism, std::to_string(terms.size()), gain, 0.01, {}, 1.0});
    removeSmall(terms);
    std::string ids;
    for (const SelectedTerm& one : terms) ids += one.member;
    return ids;
  };
  const Mechanism acid = Mechanism::kAcid, ageing = Mechanism::kAgeing;
  EXPECT_EQ("012", left({{acid, 300.0}, {ageing, 31.0}, {ageing, 30.0}, {ageing, 29.0}}));
  EXPECT_EQ("02", left({{acid, 300.0}, {ageing, 29.0}, {acid, 2.0}})) << "parts of one mechanism";
  EXPECT_EQ("0", left({{acid, -3.0}}));
  EXPECT_EQ("", left({}));
}

TEST(Summary, OfEveryVerdictIsOneSentenceThatIsReadOnce) {
  for (const Verdict verdict :
       {Verdict::kNoMismatch, Verdict::kEffect, Verdict::kSeveral, Verdict::kAmbiguous,
        Verdict::kMechanism, Verdict::kUnexplained, Verdict::kSensorFault}) {
    const std::string summary = summaryOf(judgedAs(verdict));
    EXPECT_LE(summary.size(), 360u) << summary;  // four effects by name
    EXPECT_EQ(std::string::npos, summary.find(". ")) << summary;
    EXPECT_EQ('.', summary.back());
  }
}

TEST(Summary, OfAnEffectSaysWhatIsMissingHowSureWhatItCostsAndWhatIsGained) {
  Diagnosis diagnosis = judgedAs(Verdict::kEffect);
  diagnosis.mechanism = Mechanism::kAcid;
  diagnosis.probability = 0.7;
  diagnosis.mechanisms = {{Mechanism::kAcid, 0.7}};
  EXPECT_EQ("Missing: " + effectInfo("acid_transport").title +
                " (probability 0.70); on the hold-out the circuit deviates by 300.0 mV RMS, the "
                "extended model by "
                "100.0 mV.",
            summaryOf(diagnosis));
}

TEST(Summary, OfSeveralNamesThemAllAndOfTheIndistinguishableNamesTheMechanism) {
  Diagnosis several = judgedAs(Verdict::kSeveral);
  several.probability = 0.96;
  EXPECT_TRUE(says(several, "Four effects are missing: the likeliest one (96 %): " +
                                titleOf("acid_transport") + "; the others: "));
  for (const NamedEffect& effect : several.effects) EXPECT_TRUE(says(several, titleOf(effect.id)));
  several.effects.resize(2);
  EXPECT_TRUE(says(
      several, "Two effects are missing: the likelier one (96 %): " + titleOf("acid_transport") +
                   "; the other: " + titleOf(several.effects[1].id)));
  Diagnosis ambiguous = judgedAs(Verdict::kAmbiguous);
  ambiguous.mechanism = Mechanism::kAcid;
  EXPECT_TRUE(says(ambiguous, mechanismSentence(Mechanism::kAcid) +
                                  ", for which several equations fit equally well"));
  EXPECT_FALSE(says(ambiguous, effectInfo("acid_transport").title));
  ambiguous.mechanism = Mechanism::kAgeing;
  EXPECT_TRUE(says(ambiguous, mechanismSentence(Mechanism::kAgeing) +
                                  ", although the equation that fits belongs to acid"));
}

TEST(Summary, SaysWhichMechanismIsTheSecondLikeliest) {
  EXPECT_TRUE(says(judgedAs(Verdict::kMechanism), "(probability 0.60; next side_reactions 0.21)"));
  Diagnosis sure = judgedAs(Verdict::kMechanism);
  sure.mechanisms.resize(1);
  EXPECT_FALSE(says(sure, "side_reactions"));
}

TEST(Summary, WithoutAnEquationSaysWhetherACorrectionIsEstimated) {
  Diagnosis diagnosis = judgedAs(Verdict::kUnexplained);
  EXPECT_TRUE(says(diagnosis, "no mechanism explains"));
  EXPECT_TRUE(says(diagnosis, "no correction estimated"));
  diagnosis = judgedAs(Verdict::kMechanism);
  EXPECT_TRUE(says(diagnosis, mechanismSentence(Mechanism::kOpenCircuit)));
  EXPECT_TRUE(says(diagnosis, "no correction estimated"));
  diagnosis.discrepancy.emplace();
  EXPECT_TRUE(says(diagnosis, "no correction estimated")) << "it is not used";
  diagnosis.discrepancy->is_used = true;
  EXPECT_TRUE(says(diagnosis, "the extended model by 100.0 mV"));
}

TEST(Summary, OfAChargedBatterySaysHowMuchOfCurrentAndVoltageIsExplained) {
  Diagnosis diagnosis = judgedAs(Verdict::kEffect);
  diagnosis.fit.base_holdout.share_percent = -8.7;
  diagnosis.fit.extended_holdout.share_percent = 57.1;
  EXPECT_TRUE(says(diagnosis, "explains -9 % of current and voltage, the extended model 57 %"));
  EXPECT_FALSE(says(diagnosis, "mV RMS"));
}

TEST(Summary, OfAnExtendedModelThatIsNoImprovementSaysSoInItsFirstSentence) {
  Diagnosis diagnosis = judgedAs(Verdict::kEffect);
  diagnosis.effects.resize(std::max<std::size_t>(1, diagnosis.effects.size()));
  diagnosis.fit.extended_holdout.rmse = 0.4;
  diagnosis.withheld_rmse = 0.4;
  EXPECT_TRUE(says(diagnosis,
                   ", but this does not improve the prediction; on the hold-out the circuit "
                   "deviates by 300.0 mV RMS, the extended model by 400.0 mV"))
      << summaryOf(diagnosis);
  diagnosis.fit.base_holdout.share_percent = 30.0;
  diagnosis.fit.extended_holdout.share_percent = 5.0;
  EXPECT_TRUE(says(diagnosis,
                   ", but this does not improve the prediction; on the hold-out the circuit "
                   "explains 30 % of current and voltage, the extended model 5 %"))
      << summaryOf(diagnosis);
}

/// A block that the others do not determine is missed by more than anything that is missing.
TEST(DiscrepancyFinding, HoldsWhereItMissesLeftOutBlocksByLessThanTheCircuitFittedToThem) {
  DiscrepancyFinding finding;
  EXPECT_FALSE(finding.holds());
  finding.is_used = true;
  finding.left_out = {0.300, 0.140, 0.150};
  EXPECT_TRUE(finding.holds());
  finding.left_out = {0.300, 0.140, 0.004};
  EXPECT_FALSE(finding.holds());
  finding.left_out = {0.150, 0.140, 0.150};
  EXPECT_FALSE(finding.holds()) << "less than a tenth";
}

TEST(NextExperiment, TellsTheIndistinguishableApart) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kAmbiguous;
  NamedEffect acid;
  acid.id = "acid_transport";
  acid.indistinguishable_from = {"ocv_soc"};
  diagnosis.effects = {acid};
  EXPECT_NE(std::string::npos, nextExperiment(diagnosis).find("ocv_soc"));
  EXPECT_NE(std::string::npos,
            nextExperiment(diagnosis).find(effectInfo("acid_transport").distinguished_by));
}

TEST(NextExperiment, OfAnInstrumentsFaultFitsTheFault) {
  std::vector<std::string> ids = {"clipping", "dropouts", "quantisation", "aliasing"};
  for (const EffectInfo& info : effectCatalogue())
    if (mechanismOf(info.id) == Mechanism::kInstrument) ids.push_back(info.id);
  EXPECT_GT(ids.size(), 8u);
  std::set<std::string> advice;
  for (const std::string& id : ids) {
    Diagnosis diagnosis;
    diagnosis.verdict = Verdict::kSensorFault;
    diagnosis.effects.resize(1);
    diagnosis.effects.front().id = id;
    advice.insert(nextExperiment(diagnosis));
  }
  EXPECT_EQ(advice.size(), ids.size());
}

TEST(NextExperiment, OfAShiftBetweenTheChannelsIsTheCommandThatUndoesIt) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kSensorFault;
  diagnosis.effects.resize(1);
  diagnosis.effects.front().id = "time_skew";
  EXPECT_NE(nextExperiment(diagnosis).find("sof convert IN OUT --shift-current"),
            std::string::npos);
  diagnosis.effects.front().parameters.resize(1);
  diagnosis.effects.front().parameters.front().name = "channel_skew";
  diagnosis.effects.front().parameters.front().value = -0.0472;
  EXPECT_NE(nextExperiment(diagnosis).find("sof convert IN OUT --shift-current -0.0472)"),
            std::string::npos);
}

TEST(NextExperiment, IsToUndoAShiftThatTheChecksFoundWhateverElseIsMissing) {
  Diagnosis diagnosis;
  for (const Verdict verdict : {Verdict::kMechanism, Verdict::kUnexplained, Verdict::kNoMismatch}) {
    diagnosis.verdict = verdict;
    EXPECT_NE(nextExperiment(diagnosis, 0.047).find("--shift-current 0.047)"), std::string::npos);
    EXPECT_EQ(nextExperiment(diagnosis).find("--shift-current"), std::string::npos);
  }
}

}  // namespace
}  // namespace battery_sof
