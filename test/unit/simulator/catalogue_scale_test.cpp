#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "simulator/generator/catalogue_draft.hpp"
#include "support/circuit_truth.hpp"
#include "support/drawn_scenarios.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kCut = 30.0;  // [s]
const std::set<std::string> kWithCompanion{"gassing", "sulphate_history"};
const std::set<std::string> kNotLinear{"quantisation", "clipping", "dropouts"};

/// A scenario under given currents every millisecond in place of its drive and limit.
Scenario underCurrents(Scenario s, const std::vector<double>& currents) {
  ListedPhases listed;
  for (std::size_t n = 1; n < currents.size(); ++n)
    listed.phases.push_back(steady(FullBattery::kStep, currents[n]));
  s.profile = listed;
  s.inserts.clear();
  s.later.reset();
  s.voltage_limit = s.slew = 1e9;
  s.duration = static_cast<double>(currents.size() - 1) * FullBattery::kStep;
  return s;
}

/// A case on a drive that shows a little of everything within a minute.
CatalogueDraft lively(const ScenarioKind& kind, double scale) {
  CatalogueDraft draft = drawCatalogue(orderOf(kind, 2, 120.0, {scale}));
  Scenario& s = draft.scenario;
  s.profile = AlternatingOptions{};
  s.inserts = {{5.0, {{1.0, -250.0, -250.0}}},
               {8.0, {{6.0, -90.0, -90.0}}},
               {15.0, {{12.0, 40.0, 40.0, 14.2}}}};
  s.additions.contact_from_s = 10.0;
  return draft;
}

std::vector<ScenarioKind> kindsOf(const std::set<std::string>& names) {
  std::vector<ScenarioKind> kinds;
  for (const ScenarioKind& kind : scenarioKinds())
    if (names.count(kind.kind) > 0) kinds.push_back(kind);
  return kinds;
}

bool same(const std::vector<RecordedSample>& a, const std::vector<RecordedSample>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const RecordedSample& x, const RecordedSample& y) {
                      return x.time == y.time && x.current == y.current && x.voltage == y.voltage;
                    });
}

std::vector<RecordedSample> cut(const Scenario& scenario) {
  SimulationOptions options;
  options.cut_after = kCut;
  return simulate(scenario, options).samples;
}

TEST(CatalogueScale, AtZeroNothingIsLeftButWhatTheAdditionNeeds) {
  const AcquisitionOptions fine =
      drawCatalogue(orderOf({"base_control", "-"}, 2, 120.0)).scenario.acquisition;
  for (const ScenarioKind& kind : kindsOf({"effect", "instrument_fault", "unlisted_law"})) {
    const CatalogueDraft gone = lively(kind, 0.0);
    CatalogueDraft nested = gone;
    nested.scenario.effects = plainCircuit();
    nested.scenario.effects.charge_acceptance = kWithCompanion.count(kind.id) > 0;
    nested.scenario.additions = {};
    nested.scenario.battery.i0_a = 1.0;
    nested.scenario.battery.alpha = 0.5;
    nested.scenario.acquisition = fine;
    EXPECT_TRUE(same(cut(gone.scenario), cut(nested.scenario))) << kind.kind << " " << kind.id;
    EXPECT_FALSE(same(cut(lively(kind, 1.0).scenario), cut(nested.scenario))) << kind.id;
    const std::vector<std::string> left = kWithCompanion.count(kind.id) > 0
                                              ? std::vector<std::string>{"charge_acceptance"}
                                              : std::vector<std::string>{};
    EXPECT_EQ(gone.effects, left) << kind.id;
  }
}

/// What a scale adds to a quiet recording of given currents, volts and hundredths of amperes.
std::vector<double> deviation(const ScenarioKind& kind, double scale,
                              const std::vector<double>& currents) {
  const auto recordingAt = [&](double at) {
    CatalogueDraft draft = lively(kind, at);
    draft.order.quiet = true;
    return simulate(underCurrents(recordedScenario(draft), currents)).samples;
  };
  const auto with = recordingAt(scale), without = recordingAt(0.0);
  std::vector<double> difference;
  for (std::size_t n = 0; n < std::min(with.size(), without.size()); ++n) {
    difference.push_back(with[n].voltage - without[n].voltage);
    difference.push_back(0.01 * (with[n].current - without[n].current));
  }
  return difference;
}

TEST(CatalogueScale, ASmallScaleActsInProportion) {
  for (const ScenarioKind& kind : kindsOf({"effect", "instrument_fault", "unlisted_law"})) {
    if (kNotLinear.count(kind.id) > 0) continue;
    const auto currents = truthOf(lively(kind, 0.0).scenario, 1, kCut).current;
    const auto once = deviation(kind, 0.01, currents), twice = deviation(kind, 0.02, currents);
    double size = 0.0, off = 0.0;
    for (std::size_t n = 0; n < once.size(); ++n) {
      size += twice[n] * twice[n];
      off += std::pow(twice[n] - 2.0 * once[n], 2);
    }
    EXPECT_GT(size, 0.0) << kind.id;
    EXPECT_LT(std::sqrt(off / size), 0.05) << kind.kind << " " << kind.id;
  }
}

TEST(CatalogueScale, TheSameIsDrawnAtEveryScale) {
  for (const ScenarioKind& kind : scenarioKinds()) {
    if (!isOfCatalogue(kind) || kind.id == "-") continue;
    const CatalogueDraft once = drawCatalogue(orderOf(kind, 9, 300.0));
    const CatalogueDraft half = drawCatalogue(orderOf(kind, 9, 300.0, {0.5}));
    const auto a = nlohmann::json::parse(labelOf(once, {}));
    const auto b = nlohmann::json::parse(labelOf(half, {}));
    for (const char* key : {"profile", "inserts", "voltage_limit_v"})
      EXPECT_EQ(a["truth"][key], b["truth"][key]) << kind.kind << " " << kind.id;
    ASSERT_EQ(once.strength.size(), half.strength.size());
    bool changed = false;
    for (const auto& [key, value] : once.strength) {
      ASSERT_EQ(half.strength.count(key), 1u) << key;
      changed |= half.strength.at(key) != value;
    }
    EXPECT_TRUE(changed) << kind.kind << " " << kind.id;
    EXPECT_EQ(a["strength"]["scale"], nlohmann::json(once.order.scale));
    EXPECT_EQ(once.order.scale, std::vector<double>(additionsOf(kind).size(), 1.0));
  }
}

TEST(CatalogueScale, TheTimeConstantOfASecondElectrodeStays) {
  const Additions a = lively({"effect", "second_electrode"}, 1.0).scenario.additions;
  const Additions b = lively({"effect", "second_electrode"}, 0.25).scenario.additions;
  EXPECT_DOUBLE_EQ(b.electrode3_beta_per_v, 4.0 * a.electrode3_beta_per_v);
  EXPECT_DOUBLE_EQ(b.electrode3_capacitance_f / b.electrode3_beta_per_v,
                   a.electrode3_capacitance_f / a.electrode3_beta_per_v);
}

TEST(CatalogueScale, RefusesANegativeOneAndTooMany) {
  EXPECT_THROW(drawCatalogue(orderOf({"effect", "gassing"}, 1, 60.0, {-0.1})),
               std::invalid_argument);
  EXPECT_THROW(drawCatalogue(orderOf({"effect", "gassing"}, 1, 60.0, {1.0, 1.0})),
               std::invalid_argument);
  EXPECT_THROW(drawCatalogue(orderOf({"base_control", "-"}, 1, 60.0, {2.0})),
               std::invalid_argument);
}

TEST(Quiet, HasNoNoiseAndNoStepsButKeepsTheSensorsFaults) {
  CatalogueDraft draft = drawCatalogue(orderOf({"instrument_fault", "current_offset"}, 4, 60.0));
  draft.scenario.profile = ListedPhases{};
  draft.scenario.inserts.clear();
  const auto spread = [](const std::vector<RecordedSample>& samples) {
    const auto [low, high] = std::minmax_element(
        samples.begin(), samples.end(),
        [](const RecordedSample& a, const RecordedSample& b) { return a.voltage < b.voltage; });
    return high->voltage - low->voltage;
  };
  EXPECT_GT(spread(simulate(recordedScenario(draft)).samples), 1e-3);
  draft.order.quiet = true;
  const auto quiet = simulate(recordedScenario(draft)).samples;
  EXPECT_LT(spread(quiet), 1e-9);
  EXPECT_NEAR(quiet.front().current, draft.strength.at("current_offset_a"), 1e-9);
  const auto label = nlohmann::json::parse(labelOf(draft, Simulation{}));
  EXPECT_TRUE(label["quiet"].get<bool>());
  EXPECT_GT(label["truth"]["acquisition"]["voltage_white_v"].get<double>(), 0.0);
}

TEST(Masked, HasBothAdditionsEachAtItsOwnScale) {
  for (const ScenarioKind& kind : kindsOf({"masked"})) {
    const CatalogueDraft draft = drawCatalogue(orderOf(kind, 5, 600.0, {1.0, 0.5}));
    const auto label = nlohmann::json::parse(labelOf(draft, Simulation{}));
    EXPECT_EQ(label["expected"]["effects"], nlohmann::json(additionsOf(kind)));
    EXPECT_EQ(label["expected"]["verdicts"], nlohmann::json({"named", "several", "ambiguous"}));
    EXPECT_EQ(label["strength"]["scale"], nlohmann::json({1.0, 0.5}));
    const CatalogueDraft alone = drawCatalogue(orderOf(kind, 5, 600.0, {1.0, 0.0}));
    EXPECT_EQ(alone.effects, std::vector<std::string>{additionsOf(kind).front()});
    const CatalogueDraft second = drawCatalogue(orderOf(kind, 5, 600.0, {0.0, 1.0}));
    EXPECT_EQ(second.effects, std::vector<std::string>{additionsOf(kind).back()});
  }
}

TEST(Masked, TheSecondAdditionActsAgainstTheFirst) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto drawn = [&](const std::string& id) {
      return drawCatalogue(orderOf({"masked", id}, seed, 600.0)).scenario;
    };
    EXPECT_GT(drawn("charge_acceptance+current_gain").acquisition.current_gain_charge, 1.0);
    EXPECT_GT(drawn("charge_acceptance+gassing").battery.lead_ion_limit_a, 20.0);
    const Scenario s = drawn("ocv_soc+voltage_drift");
    EXPECT_LT(std::get<CityOptions>(s.profile).net_charge_ah * s.acquisition.voltage_drift_v_per_h,
              0.0);
  }
}

/// Currents and voltages of a battery every millisecond, with the effect and without.
struct Halves {
  Truth with, without;
  std::size_t middle;

  double rms(bool first) const {
    const std::size_t begin = first ? 0 : middle, end = first ? middle : with.voltage.size();
    double sum = 0.0;
    for (std::size_t n = begin; n < end; ++n)
      sum += std::pow(with.voltage[n] - without.voltage[n], 2);
    return std::sqrt(sum / static_cast<double>(end - begin));
  }
  /// Longest stretch of the first half in which a condition on the current holds [s].
  template <typename Condition>
  double longest(const Condition& holds) const {
    std::size_t run = 0, most = 0;
    for (std::size_t n = 0; n < middle; ++n) {
      run = holds(with.current[n]) ? run + 1 : 0;
      most = std::max(most, run);
    }
    return FullBattery::kStep * static_cast<double>(most);
  }
};

Halves halvesOf(const std::string& id, std::uint64_t seed, double duration) {
  const CatalogueDraft draft = drawCatalogue(orderOf({"absent", id}, seed, duration));
  EXPECT_EQ(draft.regime_from, 0.5 * duration);
  const CatalogueDraft gone = drawCatalogue(orderOf({"absent", id}, seed, duration, {0.0}));
  Halves halves;
  halves.with = truthOf(draft.scenario);
  halves.without = truthOf(underCurrents(gone.scenario, halves.with.current));
  halves.middle = static_cast<std::size_t>(*draft.regime_from / FullBattery::kStep);
  return halves;
}

TEST(Absent, OnlyTheSecondHalfShowsTheEffect) {
  for (const ScenarioKind& kind : kindsOf({"absent"})) {
    // A plateau must outlast what its companion can take: docs/validation.md.
    const Halves halves = halvesOf(kind.id, 3, kind.id == "gassing" ? 900.0 : 400.0);
    EXPECT_GT(halves.rms(false), 4.0 * halves.rms(true)) << kind.id;
    EXPECT_GT(halves.rms(true), 0.0) << kind.id;
  }
}

TEST(Absent, TheFirstHalfHasNothingOfTheRegime) {
  const Halves charging = halvesOf("charge_acceptance", 4, 400.0);
  EXPECT_LT(charging.longest([](double i) { return i > 0.5; }), 8.0);
  const Halves gassing = halvesOf("gassing", 4, 400.0);
  EXPECT_LT(*std::max_element(gassing.with.voltage.begin(),
                              gassing.with.voltage.begin() + static_cast<long>(gassing.middle)),
            13.401);
  const Halves heavy = halvesOf("high_rate_depletion", 4, 400.0);
  EXPECT_LT(heavy.longest([](double i) { return i < -40.0; }), 8.0);
  const Halves acid = halvesOf("acid_transport", 4, 400.0);
  EXPECT_LT(acid.longest([](double i) { return std::abs(i) < 0.1; }), 10.0);
  double charge = 0.0, lowest = 0.0, highest = 0.0;
  for (std::size_t n = 0; n < acid.middle; ++n) {
    charge += acid.with.current[n] * FullBattery::kStep / 3600.0;
    lowest = std::min(lowest, charge);
    highest = std::max(highest, charge);
  }
  EXPECT_LT(highest - lowest, 0.1);
}

TEST(LaterPart, CutsWhatPlaysAndTakesOverAtItsInstant) {
  Scenario scenario;
  scenario.duration = 4.0;
  scenario.profile = ListedPhases{{{100.0, -10.0, -10.0}}};
  scenario.inserts = {{1.0, {{100.0, -20.0, -20.0}}}, {3.0, {{0.5, -30.0, -30.0}}}};
  scenario.later = LaterPart{2.0, 14.0, ListedPhases{{{1.0, -5.0, -5.0}}}};
  const auto current = truthOf(scenario).current;
  EXPECT_DOUBLE_EQ(current[2000], -10.0);
  EXPECT_DOUBLE_EQ(current[2010], -5.0);
  EXPECT_DOUBLE_EQ(current[3100], -30.0);
  EXPECT_DOUBLE_EQ(current[3900], -5.0);
  scenario.later->from = 5.0;
  EXPECT_THROW(simulate(scenario), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof_simulator
