#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "simulator/generator/catalogue_draft.hpp"
#include "support/drawn_scenarios.hpp"

namespace battery_sof_simulator {
namespace {

namespace fs = std::filesystem;

class DrawScenario : public DrawInFolder {
 protected:
  int draw(const std::string& kind, const std::string& id, std::uint64_t seed) {
    return DrawInFolder::draw(
        {"--kind", kind, "--id", id, "--seed", std::to_string(seed), "--duration", "60"});
  }
};

TEST_F(DrawScenario, ListsEveryKindWithItsIds) {
  EXPECT_EQ(run({"--list"}), 0);
  std::istringstream lines(out_);
  std::multiset<std::string> kinds;
  for (std::string kind, mechanism, id; lines >> kind >> mechanism >> id;) kinds.insert(kind);
  EXPECT_EQ(kinds.count("base_control"), 1u);
  EXPECT_EQ(kinds.count("structural_control"), 1u);
  EXPECT_EQ(kinds.count("effect"), 18u);
  EXPECT_EQ(kinds.count("instrument_fault"), 10u);
  EXPECT_EQ(kinds.count("unlisted_law"), 6u);
  EXPECT_EQ(kinds.count("structural_effect"), 7u);
  EXPECT_EQ(kinds.count("porous_control"), 1u);
  EXPECT_EQ(kinds.count("porous_effect"), 3u);
  EXPECT_EQ(kinds.count("masked"), 4u);
  EXPECT_EQ(kinds.count("absent"), 4u);
  EXPECT_EQ(kinds.count("deep_cycle"), 1u);
}

TEST_F(DrawScenario, EveryKindListedCanBeDrawnAndSaysWhatIsTrue) {
  for (const ScenarioKind& kind : scenarioKinds()) {
    if (!isOfCatalogue(kind)) continue;
    ASSERT_EQ(draw(kind.kind, kind.id, 3), 0) << kind.kind << " " << kind.id << err_;
    const auto json = nlohmann::json::parse(contentOf(label()));
    EXPECT_EQ(json["kind"], kind.kind);
    EXPECT_EQ(json["id"], kind.id);
    EXPECT_FALSE(json["expected"]["verdicts"].empty());
    const auto effects = json["expected"]["effects"].get<std::vector<std::string>>();
    for (const std::string& id : additionsOf(kind))
      EXPECT_EQ(std::count(effects.begin(), effects.end(), id) > 0, kind.kind != "unlisted_law")
          << kind.kind << " " << id;
    EXPECT_EQ(json.count("regime_from_s"), kind.kind == "absent" ? 1u : 0u);
    EXPECT_EQ(contentOf(recording()).find("time_s,current_a,voltage_v\n"), 0u);
  }
}

TEST_F(DrawScenario, ADeepCycleRunsABlockDownAndSaysWhatItHolds) {
  std::set<std::string> plans;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    ASSERT_EQ(DrawInFolder::draw({"--kind", "deep_cycle", "--seed", std::to_string(seed)}), 0)
        << err_;
    const auto json = nlohmann::json::parse(contentOf(label()));
    plans.insert(json["plan"].get<std::string>());
    const double usable = json["usable_ah"], nominal = json["nominal_ah"];
    EXPECT_GT(usable, 0.3 * nominal) << seed;
    EXPECT_LT(usable, 1.3 * nominal) << seed;
    EXPECT_LT(json["soc_at_end"].get<double>(), 0.7) << seed;
    std::istringstream rows(contentOf(recording()));
    std::string header;
    std::getline(rows, header);
    double time = 0.0, current = 0.0, voltage = 0.0, lowest = 0.0, least = 99.0;
    for (char comma = 0; rows >> time >> comma >> current >> comma >> voltage;) {
      lowest = std::min(lowest, current);
      least = std::min(least, voltage);
    }
    EXPECT_NEAR(lowest, -json["discharge_a"].get<double>(), 0.01) << seed;
    EXPECT_GT(least, 10.3) << seed;
    EXPECT_GT(time, 3600.0) << seed;
  }
  EXPECT_EQ(plans.size(), 3u);
  EXPECT_EQ(DrawInFolder::draw({"--kind", "deep_cycle", "--seed", "1", "--rate", "10"}), 2);
}

TEST_F(DrawScenario, TheSameSeedGivesTheSameBytesAndAnotherSeedOthers) {
  ASSERT_EQ(draw("effect", "acid_transport", 5), 0);
  const std::string recording_once = contentOf(recording()), label_once = contentOf(label());
  ASSERT_EQ(draw("effect", "acid_transport", 5), 0);
  EXPECT_EQ(contentOf(recording()), recording_once);
  EXPECT_EQ(contentOf(label()), label_once);
  ASSERT_EQ(draw("effect", "acid_transport", 6), 0);
  EXPECT_NE(contentOf(recording()), recording_once);
}

TEST_F(DrawScenario, SeedsMayHaveAll64Bits) {
  const std::uint64_t large = std::uint64_t{1} << 63;
  ASSERT_EQ(draw("masked", "charge_acceptance+gassing", large), 0) << err_;
  EXPECT_EQ(nlohmann::json::parse(contentOf(label()))["seed"].get<std::uint64_t>(), large);
  const std::string once = contentOf(recording());
  ASSERT_EQ(draw("masked", "charge_acceptance+gassing", large + 1), 0);
  EXPECT_NE(contentOf(recording()), once);
  ASSERT_EQ(draw("masked", "charge_acceptance+gassing", 0), 0);
  EXPECT_NE(contentOf(recording()), once);
}

TEST_F(DrawScenario, AQuietRecordingIsWrittenWithManyDigits) {
  ASSERT_EQ(
      DrawInFolder::draw({"--kind", "masked", "--id", "current_dependent_resistance+time_skew",
                          "--quiet", "--scale", "0.5,2", "--duration", "60"}),
      0)
      << err_;
  std::istringstream rows(contentOf(recording()));
  std::string row;
  std::size_t most = 0;
  for (std::getline(rows, row); std::getline(rows, row);)
    most = std::max(most, row.size() - row.rfind('.'));
  EXPECT_GE(most, 9u);  // point and eight digits
  const auto json = nlohmann::json::parse(contentOf(label()));
  EXPECT_EQ(json["strength"]["scale"], nlohmann::json({0.5, 2.0}));
}

TEST_F(DrawScenario, AbsentTakesFortyMinutesUnlessAskedOtherwise) {
  EXPECT_EQ(usualDuration({"absent", "gassing"}), 2400.0);
  EXPECT_EQ(usualDuration({"effect", "gassing"}), 1200.0);
}

TEST_F(DrawScenario, RefusesWrongUsageInWordsAndWritesNothing) {
  EXPECT_EQ(run({"--kind", "base_control"}), 2);
  EXPECT_NE(err_.find("--out and --label are required"), std::string::npos) << err_;
  EXPECT_EQ(DrawInFolder::draw({"--kind", "effect", "--id", "rust"}), 2);
  EXPECT_NE(err_.find("\"effect rust\""), std::string::npos) << err_;
  EXPECT_EQ(DrawInFolder::draw({"--kind", "base_control", "--duration", "1"}), 2);
  EXPECT_EQ(DrawInFolder::draw({"--kind", "base_control", "--rate", "300"}), 2);
  EXPECT_EQ(DrawInFolder::draw({"--kind", "base_control", "--scale", "2"}), 2);
  EXPECT_EQ(DrawInFolder::draw({"--kind", "effect", "--id", "gassing", "--scale", "-1"}), 2);
  EXPECT_NE(err_.find("expected 0 or more"), std::string::npos) << err_;
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST(CatalogueDraft, ABaseControlIsTheBaseCircuitAndNothingElse) {
  const CatalogueDraft draft = drawCatalogue(orderOf({"base_control", "-"}, 11, 600.0));
  const BatteryEffects& e = draft.scenario.effects;
  EXPECT_FALSE(e.inductance || e.cpe1 || e.cpe2_fractional || e.r1_smooth || e.ocv_slope);
  EXPECT_FALSE(e.r1_current_dependence || e.charge_acceptance || e.self_heating);
  EXPECT_EQ(e.gassing, GassingLaw::kNone);
  EXPECT_FALSE(anyOn(draft.scenario.additions));
  EXPECT_EQ(draft.scenario.battery.i0_a, 1.0);
  EXPECT_EQ(draft.scenario.battery.alpha, 0.5);
}

TEST(CatalogueDraft, ParametersLieWithinTheirRanges) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const CatalogueDraft draft = drawCatalogue(orderOf({"base_control", "-"}, seed, 600.0));
    const BatteryParameters& b = draft.scenario.battery;
    ASSERT_TRUE(faultsOf(draft.scenario).empty()) << faultsOf(draft.scenario).front();
    const double u0 = openCircuitVoltage(b, draft.scenario.start.soc).value;
    EXPECT_TRUE(u0 >= 12.4 && u0 <= 12.9) << u0;
    const double r_discharge = b.r_ohmic_ohm + b.r1_discharge_ohm;
    EXPECT_TRUE(r_discharge >= 4e-3 && r_discharge <= 8e-3) << r_discharge;
    EXPECT_TRUE(draft.scenario.voltage_limit >= 13.5 && draft.scenario.voltage_limit <= 14.6);
  }
}

TEST(CatalogueDraft, AStructuralControlHasNoTierPEffect) {
  std::set<std::string> structures;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const CatalogueDraft draft = drawCatalogue(orderOf({"structural_control", "-"}, seed, 600.0));
    structures.insert(draft.structure);
    const BatteryEffects& e = draft.scenario.effects;
    EXPECT_FALSE(e.ocv_slope || e.charge_acceptance || e.self_heating) << draft.structure;
    EXPECT_EQ(e.gassing, GassingLaw::kNone) << draft.structure;
    EXPECT_FALSE(draft.scenario.additions.acid_transport);
  }
  EXPECT_EQ(structures.size(), 4u);
}

TEST(CatalogueDraft, EveryAdditionIsWithinItsBoundsAndChangesTheRecording) {
  for (const ScenarioKind& kind : scenarioKinds()) {
    if (!isOfCatalogue(kind) || kind.id == "-" || kind.kind == "porous_effect") continue;
    CatalogueDraft with = drawCatalogue(orderOf({kind.kind, kind.id}, 2, 120.0));
    with.scenario.profile = AlternatingOptions{};
    with.scenario.inserts = {{10.0, {{1.0, -250.0, -250.0}}}, {20.0, {{40.0, 60.0, 60.0, 14.4}}}};
    CatalogueDraft without = with;
    without.scenario.effects = plainCircuit();
    without.scenario.additions = {};
    without.scenario.battery.i0_a = 1.0;
    without.scenario.battery.alpha = 0.5;
    if (kind.kind == "instrument_fault") without.scenario.acquisition = AcquisitionOptions{};
    const auto a = simulate(with.scenario).samples, b = simulate(without.scenario).samples;
    double most = a.size() == b.size() ? 0.0 : 1.0;
    for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n)
      most = std::max({most, std::abs(a[n].voltage - b[n].voltage),
                       0.01 * std::abs(a[n].current - b[n].current)});
    EXPECT_GT(most, 1e-4) << kind.kind << " " << kind.id;
  }
}

}  // namespace
}  // namespace battery_sof_simulator
