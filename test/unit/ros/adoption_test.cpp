#include "battery_sof/ros/adoption.hpp"

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

TEST(AdoptionOf, NamedPhysicsGoesOnTrialWithAllThatBelongsToIt) {
  const Adoption named = adoptionOf(saying(Verdict::kNamed, {"gassing"}), true);
  EXPECT_THAT(named.effects, ElementsAre("gassing"));
  const Adoption several = adoptionOf(saying(Verdict::kSeveral, {"gassing", "current_offset"}), true);
  EXPECT_THAT(several.effects, ElementsAre("gassing", "current_offset"));
  EXPECT_THAT(several.sentence, HasSubstr("gassing, current_offset (instrument)"));
}

TEST(AdoptionOf, NothingGoesOnTrialUnlessAskedFor) {
  const Adoption adoption = adoptionOf(saying(Verdict::kNamed, {"gassing"}), false);
  EXPECT_THAT(adoption.effects, IsEmpty());
  EXPECT_THAT(adoption.sentence, HasSubstr("adopt_diagnosis"));
}

TEST(AdoptionOf, VerdictsThatNameNoPhysicsAdoptNothingAndSayWhy) {
  for (const Verdict verdict :
       {Verdict::kNoMismatch, Verdict::kAmbiguous, Verdict::kUnknown, Verdict::kSensorFault, Verdict::kInsufficientData}) {
    const Adoption adoption = adoptionOf(saying(verdict, {"gassing"}), true);
    EXPECT_THAT(adoption.effects, IsEmpty());
    EXPECT_THAT(adoption.sentence, HasSubstr(describe(verdict)));
  }
}

TEST(AdoptionOf, WhatWasLearntGoesOnTrialWhateverTheVerdict) {
  Diagnosis diagnosis = saying(Verdict::kUnknown, {kLearnedEffect});
  diagnosis.extended.fit.force = std::make_shared<const LearnedForce>();
  const Adoption adoption = adoptionOf(diagnosis, true);
  EXPECT_THAT(adoption.effects, ElementsAre(kLearnedEffect));
  EXPECT_EQ(diagnosis.extended.fit.force, adoption.force);
}

TEST(AdoptionOf, WhatPredictsTheHoldOutWorseIsNotAdoptedAndSaysSo) {
  Diagnosis diagnosis = saying(Verdict::kNamed, {});
  diagnosis.withheld_rmse = 0.01;
  const Adoption adoption = adoptionOf(diagnosis, true);
  EXPECT_THAT(adoption.effects, IsEmpty());
  EXPECT_THAT(adoption.sentence, HasSubstr("held out worse than the base model"));
}

TEST(AdoptionOf, InstrumentsAloneAreNotAdopted) {
  const Adoption adoption = adoptionOf(saying(Verdict::kNamed, {"current_offset"}), true);
  EXPECT_THAT(adoption.effects, IsEmpty());
  EXPECT_THAT(adoption.sentence, HasSubstr("current_offset (instrument)"));
}

}  // namespace
}  // namespace battery_sof
