#include "diagnosis/mechanism_evidence.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace battery_sof {
namespace {

constexpr std::size_t kOf(Mechanism mechanism) { return static_cast<std::size_t>(mechanism); }

/// All that one mechanism says, and nothing of the others.
MechanismEvidence clearly(Mechanism mechanism) {
  MechanismEvidence evidence{};
  evidence[kOf(mechanism)] = {400.0, 300.0, 350.0};
  return evidence;
}

double sumOf(const std::vector<MechanismProbability>& all) {
  double sum = 0.0;
  for (const MechanismProbability& one : all) sum += one.probability;
  return sum;
}

TEST(MechanismProbabilities, AreOfAllMechanismsLikeliestFirstAndAddUpToOne) {
  MechanismEvidence evidence = clearly(Mechanism::kAcid);
  evidence[kOf(Mechanism::kOpenCircuit)] = {350.0, 40.0, 300.0};
  const std::vector<MechanismProbability> all = mechanismProbabilities(evidence);
  ASSERT_EQ(kMechanisms, all.size());
  EXPECT_NEAR(1.0, sumOf(all), 1e-12);
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end(), [](const auto& one, const auto& other) {
    return one.probability > other.probability;
  }));
}

TEST(MechanismProbabilities, WhatAloneHasTheEvidenceIsLikeliestOfEveryMechanism) {
  for (const Mechanism mechanism : kAllMechanisms) {
    const MechanismProbability first = mechanismProbabilities(clearly(mechanism)).front();
    EXPECT_EQ(mechanism, first.mechanism) << mechanismId(mechanism);
    EXPECT_GT(first.probability, 0.5) << mechanismId(mechanism);
  }
}

TEST(LikelyMechanisms, AreTheFewestThatAddUpToNineTenths) {
  for (const Mechanism mechanism : kAllMechanisms) {
    const MechanismEvidence evidence = clearly(mechanism);
    std::vector<MechanismProbability> likely = likelyMechanisms(evidence);
    EXPECT_GE(sumOf(likely), 0.9);
    likely.pop_back();
    EXPECT_LT(sumOf(likely), 0.9);
  }
  EXPECT_GT(likelyMechanisms(MechanismEvidence{}).size(), 5u) << "nothing says anything";
}

TEST(LikelyMechanisms, HaveTheOneThatHoldsWithItsOwnProbability) {
  const MechanismEvidence evidence = clearly(Mechanism::kAcid);
  const std::vector<MechanismProbability> all = mechanismProbabilities(evidence);
  const MechanismProbability last = all.back();
  std::vector<MechanismProbability> likely = likelyMechanisms(evidence, last.mechanism);
  EXPECT_EQ(last.mechanism, likely.back().mechanism);
  EXPECT_EQ(last.probability, likely.back().probability);
  likely.pop_back();
  ASSERT_EQ(likelyMechanisms(evidence).size(), likely.size());
  EXPECT_EQ(likely.size(), likelyMechanisms(evidence, Mechanism::kAcid).size()) << "it is there";
}

/// Whether probabilities are positive, fall, and add up to at most 1.
void expectConsistent(const std::vector<MechanismProbability>& found) {
  double before = 1.0;
  for (const MechanismProbability& one : found) {
    EXPECT_GT(one.probability, 0.0);
    EXPECT_LE(one.probability, before);
    before = one.probability;
    const auto same = [&](const auto& other) { return other.mechanism == one.mechanism; };
    EXPECT_EQ(1, std::count_if(found.begin(), found.end(), same)) << mechanismId(one.mechanism);
  }
  EXPECT_LE(sumOf(found), 1.0 + 1e-12);
}

TEST(AcceptedFirst, HasTheAcceptedWithItsProbabilityThenWhatTheEvidenceAdds) {
  for (const Mechanism clear : kAllMechanisms)
    for (const Mechanism accepted : kAllMechanisms)
      for (const double probability : {0.02, 0.35, 0.7, 0.95}) {
        const std::vector<MechanismProbability> found =
            acceptedFirst({{accepted, probability}}, clearly(clear));
        EXPECT_EQ(accepted, found.front().mechanism);
        EXPECT_EQ(probability, found.front().probability);
        expectConsistent(found);
        if (probability > 0.9) {
          EXPECT_EQ(1u, found.size()) << "nothing is to be added";
        }
        if (probability < 0.5 && clear != accepted) {
          EXPECT_EQ(clear, found[1].mechanism);
        }
        if (probability == 0.7) {
          EXPECT_GE(sumOf(found), 0.9 - 1e-12);
        }
      }
}

TEST(AcceptedFirst, OfSeveralHasThemInTheirOrderAndAMechanismOnce) {
  const std::vector<MechanismProbability> found = acceptedFirst(
      {{Mechanism::kAcid, 0.7}, {Mechanism::kStructure, 0.7}, {Mechanism::kAcid, 0.6}},
      clearly(Mechanism::kAgeing));
  ASSERT_LE(2u, found.size());
  EXPECT_EQ(Mechanism::kAcid, found[0].mechanism);
  EXPECT_EQ(0.7, found[0].probability);
  EXPECT_EQ(Mechanism::kStructure, found[1].mechanism);
  EXPECT_NEAR(0.21, found[1].probability, 1e-12);
  expectConsistent(found);
}

}  // namespace
}  // namespace battery_sof
