#include "ros/background_work.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace battery_sof {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Diagnosis saying(Verdict verdict, const std::vector<std::string>& effects) {
  Diagnosis diagnosis;
  diagnosis.verdict = verdict;
  diagnosis.extended.fit.effects = effects;
  return diagnosis;
}

TEST(AdoptionOf, NamedPhysicsIsAdoptedWithAllThatBelongsToIt) {
  const Adoption named = adoptionOf(saying(Verdict::kEffect, {"gassing"}), true);
  EXPECT_THAT(named.effects, ElementsAre("gassing"));
  const Adoption several =
      adoptionOf(saying(Verdict::kSeveral, {"gassing", "current_offset"}), true);
  EXPECT_THAT(several.effects, ElementsAre("gassing", "current_offset"));
  EXPECT_THAT(several.sentence, HasSubstr("gassing, current_offset (instrument)"));
}

TEST(AdoptionOf, NothingIsAdoptedUnlessAskedFor) {
  const Adoption adoption = adoptionOf(saying(Verdict::kEffect, {"gassing"}), false);
  EXPECT_THAT(adoption.effects, IsEmpty());
  EXPECT_THAT(adoption.sentence, HasSubstr("use_diagnosis"));
}

TEST(AdoptionOf, VerdictsThatNameNoPhysicsAdoptNothingAndSayWhy) {
  for (const Verdict verdict : {Verdict::kNoMismatch, Verdict::kAmbiguous, Verdict::kUnexplained,
                                Verdict::kSensorFault, Verdict::kInsufficientData}) {
    const Adoption adoption = adoptionOf(saying(verdict, {"gassing"}), true);
    EXPECT_THAT(adoption.effects, IsEmpty());
    EXPECT_THAT(adoption.sentence, HasSubstr(toString(verdict)));
  }
}

TEST(AdoptionOf, DiscrepancyIsAdoptedWhateverTheVerdict) {
  Diagnosis diagnosis = saying(Verdict::kUnexplained, {kDiscrepancyEffect});
  diagnosis.extended.fit.discrepancy = std::make_shared<const DiscrepancyModel>();
  const Adoption adoption = adoptionOf(diagnosis, true);
  EXPECT_THAT(adoption.effects, ElementsAre(kDiscrepancyEffect));
  EXPECT_EQ(diagnosis.extended.fit.discrepancy, adoption.discrepancy);
}

TEST(AdoptionOf, NothingIsAdoptedWhileAChargerRegulatesTheVoltage) {
  Diagnosis diagnosis = saying(Verdict::kEffect, {"gassing"});
  diagnosis.extended.fit.source = ControlModeRule();
  const Adoption adoption = adoptionOf(diagnosis, true);
  EXPECT_THAT(adoption.effects, IsEmpty());
  EXPECT_THAT(adoption.sentence, HasSubstr("chooses its effects by itself"));
}

TEST(AdoptionOf, WhatPredictsTheHoldOutWorseIsNotAdoptedAndSaysSo) {
  Diagnosis diagnosis = saying(Verdict::kEffect, {});
  diagnosis.withheld_rmse = 0.01;
  const Adoption adoption = adoptionOf(diagnosis, true);
  EXPECT_THAT(adoption.effects, IsEmpty());
  EXPECT_THAT(adoption.sentence, HasSubstr("held out worse than the base model"));
}

TEST(AdoptionOf, InstrumentsAloneAreNotAdopted) {
  const Adoption adoption = adoptionOf(saying(Verdict::kEffect, {"current_offset"}), true);
  EXPECT_THAT(adoption.effects, IsEmpty());
  EXPECT_THAT(adoption.sentence, HasSubstr("current_offset (instrument)"));
}

}  // namespace
}  // namespace battery_sof
