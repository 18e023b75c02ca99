#include "diagnosis/mechanism_evidence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

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
  const std::vector<MechanismProbability> all = mechanismProbabilities({evidence});
  ASSERT_EQ(kMechanisms, all.size());
  EXPECT_NEAR(1.0, sumOf(all), 1e-12);
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end(), [](const auto& one, const auto& other) {
    return one.probability > other.probability;
  }));
}

TEST(MechanismProbabilities, WhatAloneHasTheEvidenceIsLikeliestOfEveryMechanism) {
  for (const Mechanism mechanism : kAllMechanisms) {
    const MechanismProbability first = mechanismProbabilities({clearly(mechanism)}).front();
    EXPECT_EQ(mechanism, first.mechanism) << mechanismId(mechanism);
    EXPECT_GT(first.probability, 0.5) << mechanismId(mechanism);
  }
}

TEST(MechanismProbabilities, OfHalvesThatAreEachSureOfAnotherAreTheirMean) {
  const MechanismEvidence acid = clearly(Mechanism::kAcid), ageing = clearly(Mechanism::kAgeing);
  for (const MechanismProbability& one : mechanismProbabilities({acid, ageing, acid})) {
    double mean = 0.0;
    for (const MechanismEvidence& half : {acid, ageing, acid})
      for (const MechanismProbability& of_half : mechanismProbabilities({half}))
        if (of_half.mechanism == one.mechanism) mean += of_half.probability / 3.0;
    EXPECT_NEAR(mean, one.probability, 1e-12) << mechanismId(one.mechanism);
  }
  EXPECT_EQ(2u, likelyMechanisms({acid, ageing}).size());
}

/// The weights of the table and the header's formula.
TEST(MechanismProbabilities, FollowTheTableOfWeights) {
  constexpr std::array<std::array<double, 7>, kMechanisms> kTable =
#include "diagnosis/mechanism_weights.inc"
      ;
  MechanismEvidence evidence{};
  for (std::size_t k = 0; k < kMechanisms; ++k) {
    const auto n = static_cast<double>(k);
    evidence[k] = {60.0 - 7.0 * n, 3.0 + 2.0 * n, 0.1 * n, 0.05 * n};
  }
  const double largest[] = {60.0, 3.0 + 2.0 * (kMechanisms - 1), 0.1 * (kMechanisms - 1)};
  const auto oddsOf = [&](std::size_t k) {
    const double parts[] = {evidence[k].alone, evidence[k].lost, evidence[k].effect};
    double odds = kTable[k].back() + 3.0 * evidence[k].accepted;
    for (std::size_t j = 0; j < 3; ++j)
      odds += -kTable[k][2 * j] * std::log(1.0 + largest[j] - parts[j]) +
              kTable[k][2 * j + 1] * parts[j] / std::max(largest[j], 1.0);
    return odds;
  };
  const std::vector<MechanismProbability> all = mechanismProbabilities({evidence});
  for (const MechanismProbability& one : all)
    EXPECT_NEAR(std::log(one.probability / all.front().probability),
                oddsOf(kOf(one.mechanism)) - oddsOf(kOf(all.front().mechanism)), 1e-9)
        << mechanismId(one.mechanism);
}

TEST(LikelyMechanisms, AreTheFewestThatAddUpToNineTenths) {
  for (const Mechanism mechanism : kAllMechanisms) {
    const MechanismEvidence evidence = clearly(mechanism);
    std::vector<MechanismProbability> likely = likelyMechanisms({evidence});
    EXPECT_GE(sumOf(likely), 0.9);
    likely.pop_back();
    EXPECT_LT(sumOf(likely), 0.9);
  }
  EXPECT_GT(likelyMechanisms({MechanismEvidence{}}).size(), 5u) << "nothing says anything";
}

TEST(LikelyMechanisms, OfWhatIsNoLeadAcidBatteryHaveNoneOfLeadAndAcid) {
  const std::vector<MechanismProbability> all =
      mechanismProbabilities({clearly(Mechanism::kAcceptance)}, false);
  EXPECT_NEAR(1.0, sumOf(all), 1e-12);
  for (const MechanismProbability& one : all)
    EXPECT_FALSE(isOfLeadAcid(one.mechanism)) << mechanismId(one.mechanism);
}

double probabilityOf(Mechanism mechanism, const MechanismEvidence& evidence) {
  for (const MechanismProbability& one : mechanismProbabilities({evidence}))
    if (one.mechanism == mechanism) return one.probability;
  return 0.0;
}

double oddsOf(Mechanism mechanism, const MechanismEvidence& evidence) {
  const double p = probabilityOf(mechanism, evidence);
  return p / (1.0 - p);
}

TEST(MechanismProbabilities, GrowByTheSameOddsWithWhatWasAcceptedOfAMechanism) {
  for (const Mechanism clear : kAllMechanisms)
    for (const Mechanism accepted : kAllMechanisms)
      for (const double share : {0.25, 1.0}) {
        MechanismEvidence evidence = clearly(clear);
        const double before = oddsOf(accepted, evidence);
        evidence[kOf(accepted)].accepted = share;
        EXPECT_NEAR(std::exp(3.0 * share), oddsOf(accepted, evidence) / before, 1e-9)
            << mechanismId(accepted);
      }
}

TEST(MechanismProbabilities, OfAClearMechanismStayFirstWhateverWasAccepted) {
  for (const Mechanism clear : kAllMechanisms)
    for (const Mechanism accepted : kAllMechanisms) {
      if (probabilityOf(clear, clearly(clear)) < 0.9) continue;
      MechanismEvidence evidence = clearly(clear);
      evidence[kOf(accepted)].accepted = 1.0;
      EXPECT_EQ(clear, mechanismProbabilities({evidence}).front().mechanism)
          << mechanismId(clear) << " against " << mechanismId(accepted);
    }
}

}  // namespace
}  // namespace battery_sof
