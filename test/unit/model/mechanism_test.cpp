#include "model/mechanism.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "model/effect.hpp"

namespace battery_sof {
namespace {

TEST(Mechanism, EveryEffectOfTheCatalogueIsAMemberOfItsOneFamily) {
  for (const EffectInfo& effect : effectCatalogue())
    for (const Mechanism mechanism : kAllMechanisms) {
      const std::vector<std::string> members = namesOf(mechanism);
      const auto listed = std::count(members.begin(), members.end(), effect.id);
      EXPECT_EQ(mechanismOf(effect.id) == mechanism ? 1 : 0, listed)
          << effect.id << " in " << mechanismId(mechanism);
    }
}

TEST(Mechanism, EveryFamilyHasAMemberAnIdAndASentenceOfItsOwn) {
  std::set<std::string> ids, sentences;
  for (const Mechanism mechanism : kAllMechanisms) {
    EXPECT_FALSE(namesOf(mechanism).empty()) << mechanismId(mechanism);
    ids.insert(mechanismId(mechanism));
    sentences.insert(mechanismSentence(mechanism));
  }
  EXPECT_EQ(kMechanisms, ids.size());
  EXPECT_EQ(kMechanisms, sentences.size());
  EXPECT_EQ((std::set<std::string>{"acceptance", "side_reactions", "acid", "open_circuit",
                                   "structure", "ageing", "instrument"}),
            ids);
}

TEST(Mechanism, FaultsThatTheInstrumentScreenFindsAreTheInstruments) {
  for (const char* fault : {"clipping", "dropouts", "quantisation", "aliasing", "time_skew"})
    EXPECT_EQ(Mechanism::kInstrument, mechanismOf(fault)) << fault;
}

TEST(Mechanism, AnUnknownIdIsRefusedByName) {
  try {
    mechanismOf("phlogiston");
    FAIL() << "phlogiston has a mechanism";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string::npos, std::string(error.what()).find("phlogiston"));
  }
}

}  // namespace
}  // namespace battery_sof
