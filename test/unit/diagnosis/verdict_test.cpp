#include "diagnosis/verdict.hpp"

#include <gtest/gtest.h>

namespace battery_sof {
namespace {

SelectedTerm effect(const std::string& id, const std::vector<std::string>& indistinguishable = {}) {
  return {mechanismOf(id), id, 100.0, 0.01, indistinguishable, 1.0};
}

SelectedTerm columnsOf(Mechanism mechanism) { return {mechanism, "", 100.0, 0.01, {}, 1.0}; }

Verdict verdictOf(const std::vector<SelectedTerm>& terms,
                  const std::vector<std::string>& faults = {}, const Unexplained& rest = {}) {
  Explanation explanation;
  explanation.terms = terms;
  return judge(explanation, {faults, {}}, rest);
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

TEST(Verdict, FaultsOfTheInstrumentsDoNotHideATone) {
  Unexplained tone;
  tone.is_tone = true;
  EXPECT_EQ(Verdict::kUnexplained, verdictOf({}, {"quantisation"}, tone));
}

TEST(Verdict, WhatLooksLikeTheInstrumentsIsTheirFaultOnlyWhereTheyHaveOne) {
  EXPECT_EQ(Verdict::kUnexplained, verdictOf({columnsOf(Mechanism::kInstrument)}));
  EXPECT_EQ(Verdict::kSensorFault,
            verdictOf({columnsOf(Mechanism::kInstrument)}, {"quantisation"}));
}

TEST(Summary, SaysWhatIsPartOfSomethingUnknown) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kUnexplained;
  diagnosis.candidates = {{"contact_resistance", 200.0, 0.9, "", "instrument"},
                          {"ocv_soc", 100.0, 0.0, "others explain more of it", "open_circuit"}};
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find(effectInfo("contact_resistance").title));
  EXPECT_EQ(std::string::npos, summaryOf(diagnosis).find(effectInfo("ocv_soc").title));
}

TEST(Summary, OfSomethingUnknownSaysItsFamilyAndWhetherItIsLearnt) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kUnexplained;
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("no mechanism"));
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("nothing that could be estimated"));
  diagnosis.mechanism = Mechanism::kAcid;
  diagnosis.discrepancy.emplace();
  diagnosis.discrepancy->is_used = true;
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find(mechanismSentence(Mechanism::kAcid)));
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("is in the extended model"));
  EXPECT_EQ(std::string::npos, summaryOf(diagnosis).find("as likely"));
  diagnosis.mechanisms = {{Mechanism::kAcid, 0.6}, {Mechanism::kStructure, 0.3}};
  EXPECT_EQ(std::string::npos, summaryOf(diagnosis).find("as likely"));
  diagnosis.mechanisms = {{Mechanism::kStructure, 0.6}, {Mechanism::kAcid, 0.3}};
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("structure is at least as likely"));
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find(mechanismSentence(Mechanism::kAcid)));
  diagnosis.discrepancy->is_used = false;
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("nothing that could be estimated"));
}

TEST(Summary, OfAChargedBatterySaysHowMuchOfCurrentAndVoltageIsExplained) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kEffect;
  diagnosis.effects.emplace_back();
  diagnosis.effects.front().id = "coup_de_fouet";
  diagnosis.fit.base_holdout.rmse = diagnosis.fit.extended_holdout.rmse = 0.573;
  diagnosis.fit.base_holdout.share_percent = -8.7;
  diagnosis.fit.extended_holdout.share_percent = 57.1;
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("goes from -9 % to 57 %"));
  EXPECT_EQ(std::string::npos, summaryOf(diagnosis).find("mV RMS"));
}

TEST(Summary, SaysWhetherTheErrorOnWhatWasHeldOutFalls) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kEffect;
  diagnosis.effects.emplace_back();
  diagnosis.effects.front().id = "ocv_soc";
  diagnosis.fit.base_holdout.rmse = 0.3;
  diagnosis.fit.extended_holdout.rmse = 0.1;
  EXPECT_NE(std::string::npos,
            summaryOf(diagnosis).find("the error falls from 300.0 mV to 100.0 mV"));
  diagnosis.fit.extended_holdout.rmse = 0.4;
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find(
                                   "the error does not fall: it goes from 300.0 mV to 400.0 mV"));
  diagnosis.fit.extended_holdout.rmse = 0.3;
  diagnosis.withheld_rmse = 0.4;
  EXPECT_NE(std::string::npos,
            summaryOf(diagnosis).find(
                "it goes from 300.0 mV to 400.0 mV RMS, so the base model is given"));
}

TEST(Summary, NamesTheLargestMeanErrorOfTheTableMarkedOrNot) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kUnexplained;
  diagnosis.regimes = {{"crank", "mean", 6, -1.0, -2.0, 0.5, 0.3, false},
                       {"high-voltage charge", "mean", 5, 0.899, 0.864, 0.933, 0.06, false},
                       {"post-charge rest", "mean", 345, 0.158, 0.0895, 0.226, 0.0002, true},
                       {"short charge", "end", 650, 1.2, 1.1, 1.3, 0.0002, true}};
  EXPECT_NE(std::string::npos,
            summaryOf(diagnosis).find(
                "largest in high-voltage charge: +899 mV (95 % +864 to +933 mV, 5 episodes)"));
  diagnosis.regimes = {{"crank", "mean", 6, -1.0, -2.0, 0.5, 0.3, false}};
  EXPECT_EQ(std::string::npos, summaryOf(diagnosis).find("largest"));
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

}  // namespace
}  // namespace battery_sof
