#include "diagnosis/combination.hpp"

#include <gtest/gtest.h>

namespace battery_sof {
namespace {

constexpr std::size_t kOf(Mechanism mechanism) { return static_cast<std::size_t>(mechanism); }

/// A recording with what it says of two mechanisms, by the evidence alone.
Diagnosis recordingOf(Mechanism one, double of_one, Mechanism other, double of_other) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kMechanism;
  MechanismEvidence evidence{};
  evidence[kOf(one)] = {of_one, 0.8 * of_one, 0.9 * of_one};
  evidence[kOf(other)] = {of_other, 0.8 * of_other, 0.9 * of_other};
  diagnosis.mechanism_evidence = {evidence};
  diagnosis.mechanisms = likelyMechanisms({evidence});
  diagnosis.mechanism = diagnosis.mechanisms.front().mechanism;
  return diagnosis;
}

Diagnosis silent(Verdict verdict) {
  Diagnosis diagnosis;
  diagnosis.verdict = verdict;
  diagnosis.mechanism_evidence = {MechanismEvidence{}};
  return diagnosis;
}

TEST(Combination, OfOneRecordingIsItsEvidence) {
  const Diagnosis one = recordingOf(Mechanism::kAcid, 60.0, Mechanism::kAgeing, 50.0);
  const CombinedDiagnosis combined = combine({one});
  ASSERT_EQ(one.mechanisms.size(), combined.mechanisms.size());
  EXPECT_EQ(one.mechanism, combined.mechanism);
  for (std::size_t k = 0; k < one.mechanisms.size(); ++k)
    EXPECT_EQ(one.mechanisms[k].probability, combined.mechanisms[k].probability);
}

TEST(Combination, OfTwoThatFavourOneMechanismIsSurerThanEither) {
  const Diagnosis first = recordingOf(Mechanism::kAcid, 60.0, Mechanism::kAgeing, 50.0),
                  second = recordingOf(Mechanism::kAcid, 60.0, Mechanism::kOpenCircuit, 50.0);
  const CombinedDiagnosis combined = combine({first, second});
  EXPECT_EQ(Mechanism::kAcid, combined.mechanism);
  for (const Diagnosis& one : {first, second})
    EXPECT_GT(combined.mechanisms.front().probability, one.mechanisms.front().probability);
}

TEST(Combination, GoesByTheEvidenceAndNotByTheNumberOfRecordings) {
  const Diagnosis weak = recordingOf(Mechanism::kOpenCircuit, 30.0, Mechanism::kAcid, 20.0),
                  strong = recordingOf(Mechanism::kAcid, 400.0, Mechanism::kOpenCircuit, 200.0);
  ASSERT_EQ(Mechanism::kOpenCircuit, weak.mechanism);
  EXPECT_EQ(Mechanism::kAcid, combine({weak, weak, strong}).mechanism);
}

TEST(Combination, TheSameEvidenceTwiceIsNoSurerThanOnce) {
  const Diagnosis one = recordingOf(Mechanism::kAcid, 60.0, Mechanism::kAgeing, 50.0);
  const CombinedDiagnosis twice = combine({one, one});
  ASSERT_EQ(one.mechanisms.size(), twice.mechanisms.size());
  for (std::size_t k = 0; k < one.mechanisms.size(); ++k)
    EXPECT_NEAR(one.mechanisms[k].probability, twice.mechanisms[k].probability, 1e-12);
}

TEST(Combination, DoesNotDependOnTheOrder) {
  const Diagnosis first = recordingOf(Mechanism::kAcid, 60.0, Mechanism::kAgeing, 50.0),
                  second = recordingOf(Mechanism::kStructure, 70.0, Mechanism::kAcid, 60.0);
  EXPECT_EQ(combine({first, second}).summary, combine({second, first}).summary);
}

TEST(Combination, StatesNothingWhereNoMechanismIsCommon) {
  Diagnosis first = recordingOf(Mechanism::kAcid, 60.0, Mechanism::kAgeing, 50.0),
            second = recordingOf(Mechanism::kStructure, 70.0, Mechanism::kAcid, 60.0);
  first.mechanisms = {{Mechanism::kAcid, 0.92}};
  second.mechanisms = {{Mechanism::kStructure, 0.92}};
  const CombinedDiagnosis combined = combine({first, second});
  EXPECT_FALSE(combined.mechanism);
  EXPECT_TRUE(combined.mechanisms.empty());
  EXPECT_NE(std::string::npos, combined.summary.find("not stated")) << combined.summary;
}

TEST(Combination, ARecordingWithoutMechanismContradictsNoOther) {
  const Diagnosis one = recordingOf(Mechanism::kAcid, 60.0, Mechanism::kAgeing, 50.0);
  for (const Verdict verdict :
       {Verdict::kNoMismatch, Verdict::kInsufficientData, Verdict::kUnexplained}) {
    const CombinedDiagnosis combined = combine({silent(verdict), one});
    EXPECT_EQ(one.mechanism, combined.mechanism);
    EXPECT_NE(std::string::npos, combined.summary.find("by 1 of 2")) << combined.summary;
  }
}

TEST(Combination, WithoutAnyMechanismSaysWhy) {
  const Diagnosis agrees = silent(Verdict::kNoMismatch), open = silent(Verdict::kUnexplained),
                  lacking = silent(Verdict::kInsufficientData);
  EXPECT_NE(std::string::npos, combine({agrees, lacking}).summary.find("agree"));
  EXPECT_NE(std::string::npos, combine({agrees, open}).summary.find("not stated"));
  EXPECT_NE(std::string::npos, combine({lacking, lacking}).summary.find("No recording"));
  EXPECT_FALSE(combine({agrees, open}).mechanism);
}

TEST(Combination, OfWhatIsNoLeadAcidBatteryStatesNothing) {
  Diagnosis cell = silent(Verdict::kMechanism);
  cell.mechanism = Mechanism::kStructure;
  cell.mechanisms = {{Mechanism::kStructure, 0.0}};
  cell.mechanism_evidence.clear();
  EXPECT_FALSE(combine({cell, cell}).mechanism);
}

}  // namespace
}  // namespace battery_sof
