#include "battery_sof/report/catalogue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace battery_sof {
namespace {

const std::string kBegin = "<!-- catalogue: scripts/update_effects_page writes this part -->\n";
const std::string kEnd = "<!-- end of the catalogue -->\n";

TEST(EffectsPage, HoldsTheCatalogueAsItIs) {
  std::ifstream file(std::string(BATTERY_SOF_SOURCE_DIR) + "/docs/effects.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  const auto begin = page.find(kBegin), end = page.find(kEnd);
  ASSERT_NE(begin, std::string::npos);
  ASSERT_NE(end, std::string::npos);
  const auto from = begin + kBegin.size();
  EXPECT_EQ(page.substr(from, end - from), catalogueMarkdown(effectsByTier()))
      << "docs/effects.md is behind: run scripts/update_effects_page";
}

TEST(EffectsPage, EveryEffectCitesItsOwnSectionOfThePhysics) {
  for (const EffectInfo& effect : effectCatalogue()) {
    const std::string section = "docs/physics.md#" + effect.id;
    EXPECT_TRUE(std::any_of(effect.parameters.begin(), effect.parameters.end(), [&](const ParameterInfo& info) {
      return info.source.find(section) != std::string::npos;
    })) << effect.id;
  }
}

TEST(CatalogueJson, NamesWhatAnEffectNeedsAndBends) {
  const auto history = catalogueJson({effectInfo("sulphate_history")})["effects"][0];
  EXPECT_EQ(history["needs"][0], "charge_acceptance");
  EXPECT_EQ(catalogueJson({effectInfo("gassing")})["effects"][0]["bends"][0], "u_dc");
  EXPECT_TRUE(catalogueJson({effectInfo("inductance")})["effects"][0]["needs"].empty());
}

}  // namespace
}  // namespace battery_sof
