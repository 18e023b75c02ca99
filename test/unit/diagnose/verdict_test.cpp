#include "battery_sof/diagnose/verdict.hpp"

#include <gtest/gtest.h>

namespace battery_sof {
namespace {

Naming named(const std::vector<Accepted>& accepted) {
  Naming naming;
  naming.accepted = accepted;
  return naming;
}

Accepted effect(const std::string& id, const std::vector<std::string>& tied = {}) {
  Accepted accepted;
  accepted.id = id;
  accepted.tied = tied;
  return accepted;
}

const DiagnosisThresholds kThresholds;

TEST(Verdict, NothingAcceptedAndNothingLeftIsNoMismatch) {
  EXPECT_EQ(Verdict::kNoMismatch, judge(named({}), {}, {1.0, 1.0, 0.0}, kThresholds));
}

TEST(Verdict, NothingAcceptedButSomethingLeftIsUnknown) {
  EXPECT_EQ(Verdict::kUnknown, judge(named({}), {}, {20.0, 20.0, 0.0}, kThresholds));
}

TEST(Verdict, EvidenceWorthANameThatMayNotBeNamedIsUnknown) {
  Naming naming;
  Candidate candidate{"ocv_soc", 9.0, 1.5 * kThresholds.name_evidence, 0.0, 0.0, "blocks held out of the fit are predicted no better with it"};
  naming.candidates = {candidate};
  EXPECT_EQ(Verdict::kUnknown, judge(naming, {}, {1.0, 1.0, 0.0}, kThresholds));
  naming.candidates.front().evidence = 0.5 * kThresholds.name_evidence;
  EXPECT_EQ(Verdict::kNoMismatch, judge(naming, {}, {1.0, 1.0, 0.0}, kThresholds));
  naming.candidates.front() = {"sensor_lag", 9.0, 5.0 * kThresholds.name_evidence, 0.0, 0.0, "what it takes out of the error is too small for a name"};
  EXPECT_EQ(Verdict::kNoMismatch, judge(naming, {}, {1.0, 1.0, 0.0}, kThresholds));
}

TEST(Summary, SaysWhatIsPartOfSomethingUnknown) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kUnknown;
  diagnosis.candidates = {{"contact_resistance", 9.0, 200.0, 20.0, 0.9, ""}, {"ocv_soc", 9.0, 100.0, 20.0, 0.0, "others explain more of it"}};
  EXPECT_NE(std::string::npos, summaryOf(diagnosis).find("contact_resistance"));
  EXPECT_EQ(std::string::npos, summaryOf(diagnosis).find("ocv_soc"));
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
}

TEST(Verdict, FaultsOfTheInstrumentsAreNamedWhenNothingElseIs) {
  EXPECT_EQ(Verdict::kSensorFault, judge(named({}), {{"clipping"}, {}}, {1.0, 1.0, 0.0}, kThresholds));
  EXPECT_EQ(Verdict::kNamed, judge(named({effect("cpe2")}), {{"clipping"}, {}}, {90.0, 1.0, 1.0}, kThresholds));
}

TEST(Verdict, FaultsOfTheInstrumentsDoNotHideWhatTheyCannotLeave) {
  EXPECT_EQ(Verdict::kUnknown, judge(named({}), {{"quantisation"}, {}}, {200.0, 200.0, 0.0}, kThresholds));
}

TEST(Verdict, WhatWouldBeExplainedByTheLeastGainIsNamed) {
  Remainder left{90.0, 30.0, 0.1, false, 40.0, 360.0};
  const double gain = leastGainToExplain(left, kThresholds);
  EXPECT_NEAR(0.7 / 0.3 * 360.0 - 40.0, gain, 1e-9);
  left.explained = (left.gained + gain) / (left.gained + gain + left.left);
  EXPECT_EQ(Verdict::kNamed, judge(named({effect("cpe2")}), {}, left, kThresholds));
  left.explained -= 1e-6;
  EXPECT_EQ(Verdict::kUnknown, judge(named({effect("cpe2")}), {}, left, kThresholds));
  EXPECT_EQ(0.0, leastGainToExplain({90.0, 1.0, 1.0, false, 40.0, 10.0}, kThresholds));
}

TEST(Verdict, OneEffectIsNamedAndTwoAreSeveral) {
  const Remainder well_explained{90.0, 1.0, 1.0};
  EXPECT_EQ(Verdict::kNamed, judge(named({effect("ocv_soc")}), {}, well_explained, kThresholds));
  EXPECT_EQ(Verdict::kSeveral, judge(named({effect("ocv_soc"), effect("cpe2")}), {}, well_explained, kThresholds));
}

TEST(Verdict, AnEffectThatAnotherCouldReplaceIsAmbiguous) {
  EXPECT_EQ(Verdict::kAmbiguous,
            judge(named({effect("fast_arc", {"sensor_lag"})}), {}, {90.0, 1.0, 1.0}, kThresholds));
}

TEST(Verdict, AnEffectOfTheInstrumentsAloneIsASensorFault) {
  EXPECT_EQ(Verdict::kSensorFault, judge(named({effect("time_skew")}), {}, {90.0, 1.0, 1.0}, kThresholds));
}

TEST(Verdict, ANameThatExplainsLittleOfWhatIsThereIsUnknown) {
  EXPECT_EQ(Verdict::kUnknown, judge(named({effect("contact_resistance")}), {}, {90.0, 60.0, 0.4}, kThresholds));
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
