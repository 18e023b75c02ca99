#include "battery_sof/diagnose/verdict.hpp"

#include <gtest/gtest.h>

namespace battery_sof {
namespace {

Component effect(const std::string& id, const std::vector<std::string>& tied = {}) { return {familyOf(id), id, 100.0, 0.01, tied, 1.0}; }

Component columnsOf(Family family) { return {family, "", 100.0, 0.01, {}, 1.0}; }

Verdict verdictOf(const std::vector<Component>& components, const std::vector<std::string>& faults = {}, const Unexplained& rest = {}) {
  Explanation explanation;
  explanation.components = components;
  return judge(explanation, {faults, {}}, rest);
}

Unexplained learned() {
  Unexplained rest;
  rest.is_learned = true;
  return rest;
}

TEST(Verdict, NothingExplainedAndNothingLeftIsNoMismatch) { EXPECT_EQ(Verdict::kNoMismatch, verdictOf({})); }

TEST(Verdict, NothingExplainedButSomethingLeftIsUnknown) {
  EXPECT_EQ(Verdict::kUnknown, verdictOf({}, {}, learned()));
  Unexplained tone, large;
  tone.is_tone = true;
  EXPECT_EQ(Verdict::kUnknown, verdictOf({}, {}, tone));
  large.rmse = 1.01 * kPlausible;
  EXPECT_EQ(Verdict::kUnknown, verdictOf({}, {}, large));
  large.rmse = 0.99 * kPlausible;
  EXPECT_EQ(Verdict::kNoMismatch, verdictOf({}, {}, large));
}

TEST(Verdict, AFamilyThatNoEffectStandsForIsUnknown) {
  EXPECT_EQ(Verdict::kUnknown, verdictOf({columnsOf(Family::kAcceptance)}));
  EXPECT_EQ(Verdict::kUnknown, verdictOf({columnsOf(Family::kAcceptance), effect("ocv_soc")}));
}

TEST(Verdict, AnEffectThatExplainsMoreThanAFamilyBesideItIsNamed) {
  EXPECT_EQ(Verdict::kNamed, verdictOf({effect("ocv_soc"), columnsOf(Family::kAcceptance)}));
}

TEST(Verdict, OneEffectIsNamedAndTwoAreSeveral) {
  EXPECT_EQ(Verdict::kNamed, verdictOf({effect("ocv_soc")}));
  EXPECT_EQ(Verdict::kSeveral, verdictOf({effect("ocv_soc"), effect("cpe2")}));
}

TEST(Verdict, AnEffectThatAnotherCouldReplaceIsAmbiguous) {
  EXPECT_EQ(Verdict::kAmbiguous, verdictOf({effect("acid_transport", {"high_rate_depletion"})}));
  EXPECT_EQ(Verdict::kAmbiguous, verdictOf({effect("ocv_soc"), effect("acid_transport", {"high_rate_depletion"})}));
}

TEST(Verdict, AnEffectOfTheInstrumentsAloneIsASensorFault) {
  EXPECT_EQ(Verdict::kSensorFault, verdictOf({effect("time_skew")}));
  EXPECT_EQ(Verdict::kSensorFault, verdictOf({effect("time_skew"), effect("current_offset")}));
  EXPECT_EQ(Verdict::kSeveral, verdictOf({effect("time_skew"), effect("ocv_soc")}));
}

TEST(Verdict, FaultsOfTheInstrumentsAreNamedWhenNothingElseIs) {
  EXPECT_EQ(Verdict::kSensorFault, verdictOf({}, {"clipping"}));
  EXPECT_EQ(Verdict::kSensorFault, verdictOf({}, {"clipping"}, learned()));
  EXPECT_EQ(Verdict::kNamed, verdictOf({effect("cpe2")}, {"clipping"}));
}

TEST(Verdict, FaultsOfTheInstrumentsDoNotHideATone) {
  Unexplained tone;
  tone.is_tone = true;
  EXPECT_EQ(Verdict::kUnknown, verdictOf({}, {"quantisation"}, tone));
}

TEST(Verdict, WhatLooksLikeTheInstrumentsIsTheirFaultOnlyWhereTheyHaveOne) {
  EXPECT_EQ(Verdict::kUnknown, verdictOf({columnsOf(Family::kInstrument)}));
  EXPECT_EQ(Verdict::kSensorFault, verdictOf({columnsOf(Family::kInstrument)}, {"quantisation"}));
}

TEST(Summary, SaysWhatIsPartOfSomethingUnknown) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kUnknown;
  diagnosis.candidates = {{"contact_resistance", 200.0, 0.9, "", "instrument"},
                          {"ocv_soc", 100.0, 0.0, "others explain more of it", "open_circuit"}};
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find(effectInfo("contact_resistance").title));
  EXPECT_EQ(std::string::npos, summaryOf(diagnosis).find(effectInfo("ocv_soc").title));
}

TEST(Summary, OfSomethingUnknownSaysItsFamilyAndWhetherItIsLearnt) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kUnknown;
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("no family"));
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("nothing that could be learnt"));
  diagnosis.family = Family::kAcid;
  diagnosis.learned.emplace();
  diagnosis.learned->is_used = true;
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find(familySentence(Family::kAcid)));
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("is in the extended model"));
  diagnosis.learned->is_used = false;
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("nothing that could be learnt"));
}

TEST(Summary, SaysWhetherTheErrorOnWhatWasHeldOutFalls) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kNamed;
  diagnosis.effects.emplace_back();
  diagnosis.effects.front().id = "ocv_soc";
  diagnosis.fit.base_holdout.rmse = 0.3;
  diagnosis.fit.extended_holdout.rmse = 0.1;
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("the error falls from 300.0 mV to 100.0 mV"));
  diagnosis.fit.extended_holdout.rmse = 0.4;
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("the error does not fall: it goes from 300.0 mV to 400.0 mV"));
  diagnosis.fit.extended_holdout.rmse = 0.3;
  diagnosis.withheld_rmse = 0.4;
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("it goes from 300.0 mV to 400.0 mV RMS, so the base model is given"));
}

TEST(Summary, NamesTheLargestMeanErrorOfTheTableMarkedOrNot) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kUnknown;
  diagnosis.regimes = {{"crank", "mean", 6, -1.0, -2.0, 0.5, 0.3, false},
                       {"high-voltage charge", "mean", 5, 0.899, 0.864, 0.933, 0.06, false},
                       {"post-charge rest", "mean", 345, 0.158, 0.0895, 0.226, 0.0002, true},
                       {"short charge", "end", 650, 1.2, 1.1, 1.3, 0.0002, true}};
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("largest in high-voltage charge: +899 mV (95 % +864 to +933 mV, 5 episodes)"));
  diagnosis.regimes = {{"crank", "mean", 6, -1.0, -2.0, 0.5, 0.3, false}};
  EXPECT_EQ(std::string::npos, summaryOf(diagnosis).find("largest"));
}

TEST(NextExperiment, TellsTheTiedApart) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kAmbiguous;
  NamedEffect acid;
  acid.id = "acid_transport";
  acid.tied_with = {"ocv_soc"};
  diagnosis.effects = {acid};
  EXPECT_NE(std::string::npos, nextExperiment(diagnosis).find("ocv_soc"));
  EXPECT_NE(std::string::npos, nextExperiment(diagnosis).find(effectInfo("acid_transport").tells_apart));
}

}  // namespace
}  // namespace battery_sof
