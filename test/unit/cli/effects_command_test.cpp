#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "model/effect.hpp"
#include "model/mechanism.hpp"
#include "support/sof_command.hpp"

namespace battery_sof {
namespace {

using test::Outcome;

Outcome effects(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "effects");
  return test::sof(arguments);
}

bool contains(const std::string& text, const std::string& piece) {
  return text.find(piece) != std::string::npos;
}

TEST(SofEffects, ListsEveryEffectWithCodeFamilyAndTitleOneALine) {
  const Outcome outcome = effects({});
  EXPECT_EQ(outcome.code, 0);
  for (const EffectInfo& info : effectCatalogue()) {
    const auto at = outcome.out.find("\n" + info.id + " ");
    ASSERT_NE(at, std::string::npos) << info.id;
    const std::string line = outcome.out.substr(at + 1, outcome.out.find('\n', at + 1) - at - 1);
    EXPECT_TRUE(contains(line, " " + info.code + " ")) << line;
    EXPECT_TRUE(contains(line, " " + mechanismId(mechanismOf(info.id)) + " ")) << line;
    EXPECT_TRUE(contains(line, info.title)) << line;
  }
}

TEST(SofEffects, ListsStructureThenPhysicsThenInstruments) {
  const std::string out = effects({}).out;
  EXPECT_LT(out.find(" S1 "), out.find(" S6 "));
  EXPECT_LT(out.find(" S6 "), out.find(" P1 "));
  EXPECT_LT(out.find(" P9 "), out.find(" P11 "));
  EXPECT_LT(out.find(" P11 "), out.find(" I1 "));
}

TEST(SofEffects, StatesEverythingThatIsKnownOfOneEffect) {
  for (const EffectInfo& info : effectCatalogue()) {
    const Outcome outcome = effects({info.id});
    EXPECT_EQ(outcome.code, 0);
    std::istringstream equations(info.equations);
    for (std::string line; std::getline(equations, line);) EXPECT_TRUE(contains(outcome.out, line));
    for (const auto& parameter : info.parameters) {
      EXPECT_TRUE(contains(outcome.out, parameter.name)) << info.id;
      EXPECT_TRUE(contains(outcome.out, parameter.symbol)) << info.id;
      EXPECT_TRUE(contains(outcome.out, parameter.source)) << info.id;
    }
    for (const auto& other : info.look_alikes) EXPECT_TRUE(contains(outcome.out, other)) << info.id;
    EXPECT_TRUE(contains(outcome.out, info.distinguished_by)) << info.id;
    EXPECT_TRUE(contains(outcome.out, "mechanism\n    " + mechanismId(mechanismOf(info.id)) + ": "))
        << info.id;
  }
}

TEST(SofEffects, SaysWhatIsHeldWhatIsKnownBeforehandAndWhereAStrengthVanishes) {
  const std::string out = effects({"gassing"}).out;
  EXPECT_TRUE(contains(out, "free, no effect at 0 (docs/physics.md#gassing)")) << out;
  EXPECT_TRUE(contains(out, "free, searched as a logarithm, known to a factor of 1.35")) << out;
  EXPECT_TRUE(contains(out, "held, searched as a logarithm")) << out;
  EXPECT_TRUE(contains(out, "nonlinear in   u_dc")) << out;
  EXPECT_TRUE(contains(effects({"charge_transfer"}).out, "known to +- 0.05"));
  EXPECT_TRUE(contains(effects({"sulphate_history"}).out, "needs          charge_acceptance"));
  EXPECT_TRUE(contains(effects({"cpe2"}).out, "cpe2_1 to cpe2_17 [V], begins at u_c2"));
  EXPECT_TRUE(contains(effects({"acid_transport"}).out,
                       "acid_current_1 [A], estimated where a recording begins, 0 A +- 20 A"));
}

TEST(SofEffects, GivesTheSameAsJson) {
  const auto document = nlohmann::json::parse(effects({"--json", "-"}).out);
  EXPECT_EQ(document["schema"], "battery_sof/effects/1");
  ASSERT_EQ(document["effects"].size(), effectCatalogue().size());
  for (const auto& one : document["effects"]) {
    const EffectInfo& info = effectInfo(one["id"]);
    EXPECT_EQ(one["code"], info.code);
    ASSERT_EQ(one["parameters"].size(), info.parameters.size());
    ASSERT_EQ(one["states"].size(), info.states.size());
    for (std::size_t j = 0; j < info.parameters.size(); ++j) {
      const auto& parameter = one["parameters"][j];
      EXPECT_EQ(parameter["name"], info.parameters[j].name);
      EXPECT_EQ(parameter["magnitude"], info.parameters[j].magnitude);
      EXPECT_EQ(parameter["lower"], info.parameters[j].lower);
      EXPECT_EQ(parameter["upper"], info.parameters[j].upper);
      EXPECT_EQ(parameter["held"], info.parameters[j].held);
      EXPECT_EQ(parameter["prior_std"].is_null(), !info.parameters[j].prior_std);
      EXPECT_EQ(parameter["vanishes_at"].is_null(), !info.parameters[j].vanishes_at);
    }
  }
}

TEST(SofEffects, JsonHasTheFamilyOfEveryEffectAndTheMembersOfEveryFamily) {
  const auto document = nlohmann::json::parse(effects({"--json", "-"}).out);
  for (const auto& one : document["effects"])
    EXPECT_EQ(one["mechanism"], mechanismId(mechanismOf(one["id"])));
  ASSERT_EQ(document["mechanisms"].size(), kMechanisms);
  std::size_t members = 0;
  for (const auto& mechanism : document["mechanisms"])
    for (const auto& member : mechanism["members"]) {
      EXPECT_EQ(mechanism["id"], mechanismId(mechanismOf(member)));
      ++members;
    }
  EXPECT_EQ(members, effectCatalogue().size() + 4);  // four faults of sampling are no effects
  EXPECT_EQ(nlohmann::json::parse(effects({"gassing", "--json", "-"}).out)["mechanisms"].size(),
            kMechanisms);
}

TEST(SofEffects, WritesTheJsonOfOneEffectToAFile) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("battery_sof effects " + std::to_string(getpid()) + ".json");
  EXPECT_EQ(effects({"ocv_soc", "--json", path.string()}).code, 0);
  std::ifstream file(path);
  const auto document = nlohmann::json::parse(file);
  ASSERT_EQ(document["effects"].size(), 1u);
  EXPECT_EQ(document["effects"][0]["parameters"][0]["unit"], "V/Ah");
  std::filesystem::remove(path);
}

TEST(SofEffects, RefusesAnUnknownIdWithTheKnownOnes) {
  const Outcome outcome = effects({"gasing"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_TRUE(outcome.out.empty());
  EXPECT_TRUE(contains(outcome.err, "\"gasing\" is not known"));
  for (const EffectInfo& info : effectCatalogue()) EXPECT_TRUE(contains(outcome.err, info.id));
}

}  // namespace
}  // namespace battery_sof
