#include "battery_sof/model/family.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "battery_sof/model/effect.hpp"

namespace battery_sof {
namespace {

TEST(Family, EveryEffectOfTheCatalogueIsAMemberOfItsOneFamily) {
  for (const EffectInfo& effect : effectCatalogue())
    for (const Family family : kAllFamilies) {
      const std::vector<std::string> members = membersOf(family);
      const auto listed = std::count(members.begin(), members.end(), effect.id);
      EXPECT_EQ(familyOf(effect.id) == family ? 1 : 0, listed) << effect.id << " in " << familyId(family);
    }
}

TEST(Family, MembersComeInTheCataloguesOrder) {
  for (const Family family : kAllFamilies) {
    const std::vector<std::string> members = membersOf(family);
    auto next = members.begin();
    for (const EffectInfo& effect : effectCatalogue())
      if (next != members.end() && effect.id == *next) ++next;
    EXPECT_EQ(members.end(), next) << familyId(family);
  }
}

TEST(Family, EveryFamilyHasAMemberAnIdAndASentenceOfItsOwn) {
  std::set<std::string> ids, sentences;
  for (const Family family : kAllFamilies) {
    EXPECT_FALSE(membersOf(family).empty()) << familyId(family);
    ids.insert(familyId(family));
    sentences.insert(familySentence(family));
  }
  EXPECT_EQ(kFamilies, ids.size());
  EXPECT_EQ(kFamilies, sentences.size());
  EXPECT_EQ((std::set<std::string>{"acceptance", "side_reactions", "acid", "open_circuit", "structure", "ageing", "instrument"}), ids);
}

TEST(Family, FaultsThatTheInstrumentScreenFindsAreTheInstruments) {
  for (const char* fault : {"clipping", "dropouts", "quantisation", "aliasing", "time_skew"})
    EXPECT_EQ(Family::kInstrument, familyOf(fault)) << fault;
}

TEST(Family, AnUnknownIdIsRefusedByName) {
  try {
    familyOf("phlogiston");
    FAIL() << "phlogiston has a family";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string::npos, std::string(error.what()).find("phlogiston"));
  }
}

}  // namespace
}  // namespace battery_sof
