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

TEST(MechanismEvidence, OfSeveralRecordingsAddsUp) {
  MechanismEvidence sum = clearly(Mechanism::kAgeing);
  sum += clearly(Mechanism::kAcid);
  sum += clearly(Mechanism::kAcid);
  EXPECT_EQ(800.0, sum[kOf(Mechanism::kAcid)].alone);
  EXPECT_EQ(600.0, sum[kOf(Mechanism::kAcid)].lost);
  EXPECT_EQ(700.0, sum[kOf(Mechanism::kAcid)].effect);
  EXPECT_EQ(Mechanism::kAcid, mechanismProbabilities(sum).front().mechanism);
}

}  // namespace
}  // namespace battery_sof
