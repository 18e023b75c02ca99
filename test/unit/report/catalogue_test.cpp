#include "report/results.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "diagnosis/diagnosis.hpp"

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
    EXPECT_TRUE(std::any_of(
        effect.parameters.begin(), effect.parameters.end(),
        [&](const ParameterInfo& info) { return info.source.find(section) != std::string::npos; }))
        << effect.id;
  }
}

/// The section of an effect in docs/physics.md; empty without one.
std::string physicsOf(const std::string& id) {
  std::ifstream file(std::string(BATTERY_SOF_SOURCE_DIR) + "/docs/physics.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  const auto begin = page.find("\n### " + id + "\n");
  if (begin == std::string::npos) return "";
  return page.substr(
      begin, std::min(page.find("\n### ", begin + 1), page.find("\n# ", begin + 1)) - begin);
}

TEST(PhysicsPage, SaysOfEveryEffectItsFamilySignatureLookAlikesAndOtherForms) {
  for (const EffectInfo& effect : effectCatalogue()) {
    const std::string section = physicsOf(effect.id);
    EXPECT_NE(section.find("Mechanism `" + mechanismId(mechanismOf(effect.id)) + "`"),
              std::string::npos)
        << effect.id;
    for (const char* said : {"Signature: ", "Look-alike", "Other laws: "})
      EXPECT_NE(section.find(said), std::string::npos) << effect.id << ": " << said;
    for (const std::string& other : effect.look_alikes)
      EXPECT_NE(section.find("`" + other + "`"), std::string::npos) << effect.id << ": " << other;
  }
}

TEST(CatalogueJson, NamesWhatAnEffectNeedsAndBends) {
  const auto history = catalogueJson({effectInfo("sulphate_history")})["effects"][0];
  EXPECT_EQ(history["needs"][0], "charge_acceptance");
  EXPECT_EQ(catalogueJson({effectInfo("gassing")})["effects"][0]["is_nonlinear"][0], "u_dc");
  EXPECT_TRUE(catalogueJson({effectInfo("inductance")})["effects"][0]["needs"].empty());
}

}  // namespace
}  // namespace battery_sof
