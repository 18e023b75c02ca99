#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "simulator/fields.hpp"
#include "simulator/generator/catalogue_draft.hpp"
#include "simulator/generator/law_scenario.hpp"

namespace battery_sof_simulator {
namespace {

using Json = nlohmann::json;
using Names = std::vector<std::string>;

template <typename Options>
Json jsonOf(Options options) {
  Json json = Json::object();
  for (const Field& field : fieldsOf(options))
    std::visit(
        [&](const auto* place) {
          using Value = std::decay_t<decltype(*place)>;
          if constexpr (std::is_enum_v<Value>)
            json[field.key] = namesOf(*place)[static_cast<std::size_t>(*place)];
          else if constexpr (std::is_same_v<Value, Range>)
            json[field.key] = {place->low, place->high};
          else
            json[field.key] = *place;
        },
        field.place);
  return json;
}

Json jsonOf(const ListedPhases& listed) {
  Json phases = Json::array();
  for (const Phase& phase : listed.phases) phases.push_back(jsonOf<Phase>(phase));
  return {{"phases", phases}};
}

Json profileOf(const ProfileOptions& profile) {
  Json json = std::visit([](const auto& options) { return jsonOf(options); }, profile);
  json["kind"] = kProfileKinds[profile.index()];
  return json;
}

Json insertsOf(const std::vector<Insert>& inserts) {
  Json json = Json::array();
  for (const Insert& insert : inserts) {
    json.push_back(jsonOf(ListedPhases{insert.phases}));
    json.back()["at_s"] = insert.at;
  }
  return json;
}

Json drivingTruthOf(const Scenario& s, const Simulation& simulation) {
  Json json = {{"acquisition", jsonOf(s.acquisition)},
               {"profile", profileOf(s.profile)},
               {"inserts", insertsOf(s.inserts)},
               {"voltage_limit_v", s.voltage_limit},
               {"temperature_degc", s.start.temperature},
               {"soc_at_start", simulation.soc_at_start},
               {"soc_at_end", simulation.soc_at_end},
               {"gassing_ah", simulation.balance.gas_charge / kSecondsPerHour}};
  if (s.later)
    json["later"] = {{"from_s", s.later->from},
                     {"voltage_limit_v", s.later->voltage_limit},
                     {"profile", profileOf(s.later->profile)}};
  return json;
}

/// Classes of effects that voltage and current of a drive may not separate
/// (docs/physics.md#effects-that-cannot-be-distinguished).
const std::vector<Names> kTieClasses{
    {"current_offset", "parasitic_load", "gassing", "charge_transfer"},
    {"fast_arc", "sensor_lag"},
    {"inductance", "time_skew"},
    {"ocv_soc", "acid_transport", "ocv_hysteresis"},
    {"self_heating", "contact_resistance", "parameter_drift"},
    {"charge_acceptance", "sulphate_history"},
    {"cpe2", "second_electrode"},
    {"ocv_soc", "voltage_drift"},
    {"capacitance_fall", "parameter_drift"}};

Names tiesOf(const Names& effects) {
  std::set<std::string> ties;
  for (const auto& tied : kTieClasses) {
    const bool concerned = std::any_of(tied.begin(), tied.end(), [&](const std::string& id) {
      return std::count(effects.begin(), effects.end(), id) > 0;
    });
    if (concerned) ties.insert(tied.begin(), tied.end());
  }
  for (const auto& effect : effects) ties.erase(effect);
  for (const ScenarioKind& one : scenarioKinds())
    if (one.kind == kUnlistedLaw) ties.erase(one.id);
  return {ties.begin(), ties.end()};
}

Names verdictsOf(const ScenarioKind& kind) {
  if (kind.kind == "base_control") return {"no_mismatch"};
  if (kind.kind == "structural_control" || kind.kind == "porous_control")
    return {"no_mismatch", "named", "several", "ambiguous", "unknown"};
  if (kind.id == "capacitance_fall") return {"unknown", "named"};
  if (kind.kind == kUnlistedLaw) return {"unknown"};
  if (kind.kind != "instrument_fault") return {"named", "several", "ambiguous"};
  if (kind.id == "quantisation" || kind.id == "dropouts")
    return {"no_mismatch", "sensor_fault", "insufficient_data"};
  return {"sensor_fault", "named", "ambiguous"};
}

/// What a kind is when nothing is left of its additions but what they need.
ScenarioKind nestedKind(const CatalogueDraft& draft) {
  const std::string& kind = draft.order.what.kind;
  const bool companion =
      std::count(draft.effects.begin(), draft.effects.end(), "charge_acceptance") > 0;
  if (companion) return draft.order.what;
  if (kind == "structural_effect") return {"structural_control"};
  if (kind == "porous_effect") return {"porous_control"};
  return {"base_control"};
}

/// What a good diagnosis may say: any of the verdicts, true effects, and those alike to them.
Json expectedOf(const CatalogueDraft& draft) {
  const std::vector<double>& scale = draft.order.scale;
  const bool gone = !scale.empty() && *std::max_element(scale.begin(), scale.end()) == 0.0;
  const ScenarioKind kind = gone ? nestedKind(draft) : draft.order.what;
  return {{"verdicts", verdictsOf(kind)},
          {"effects", draft.effects},
          {"ties", tiesOf(kind.kind == kUnlistedLaw ? Names{kind.id} : draft.effects)}};
}

/// Crystals stand in a label where they are: labels drawn before there were any stay what they are.
Json additionsOf(const Additions& additions) {
  Json json = jsonOf(additions);
  if (additions.sulphate_crystals) return json;
  for (const char* key :
       {"sulphate_crystals", "crystal_supply", "crystal_nuclei_ah", "crystal_ripening_s"})
    json.erase(key);
  return json;
}

Json truthOf(const CatalogueDraft& draft, const Simulation& simulation) {
  Json json = drivingTruthOf(draft.scenario, simulation);
  if (draft.scenario.porous) {
    json["porous"] = jsonOf(*draft.scenario.porous);
    return json;
  }
  json["battery"] = jsonOf(draft.scenario.battery);
  json["effects"] = jsonOf(draft.scenario.effects);
  json["additions"] = additionsOf(draft.scenario.additions);
  return json;
}

/// What every label begins with.
Json headOf(const Order& order, const Json& id, const Scenario& scenario, double rate) {
  return {{"schema", "battery_sof/scenario/1"},
          {"kind", order.what.kind},
          {"id", id},
          {"seed", order.seed},
          {"duration_s", scenario.duration},
          {"sample_rate_hz", rate}};
}

Json nameOr(const std::string& name) { return name == "-" ? Json(nullptr) : Json(name); }

Json jsonOf(const SplitRms& rms) { return {{"training", rms.training}, {"holdout", rms.holdout}}; }

Json noiseOf(const LawScenario& one) {
  return {{"voltage_white_v", one.voltage_noise.white},
          {"voltage_correlated_v", one.voltage_noise.correlated},
          {"voltage_correlation_time_s", one.voltage_noise.correlation_time},
          {"voltage_walk_v_per_sqrt_min", one.voltage_noise.walk_per_sqrt_min},
          {"voltage_step_v", one.voltage_step_v},
          {"current_white_a", one.current_noise.white},
          {"current_step_a", one.current_step_a}};
}

Json baseOf(const BatteryParameters& b) {
  return {{"r_discharge_ohm", b.r_ohmic_ohm + b.r1_discharge_ohm},
          {"r_charge_ohm", b.r_ohmic_ohm + b.r1_charge_ohm},
          {"c2_f", b.cpe2_capacitance_f},
          {"beta_per_v", b.beta_per_v},
          {"u_dc_v", b.u0_v}};
}

Json channelOf(const ImperfectChannel& c) {
  return {{"poles", c.poles},         {"corner_hz", c.corner_hz}, {"late_share", c.late_share},
          {"bow_steps", c.bow_steps}, {"ripple", c.ripple},       {"step", c.step}};
}

Json recorderOf(const LawScenario& one) {
  if (!one.recorder) return nullptr;
  const ImperfectRecorder& r = *one.recorder;
  return {{"voltage", channelOf(r.voltage)}, {"current", channelOf(r.current)},
          {"jitter_share", r.jitter_share},  {"ripple_hz", r.ripple_hz},
          {"smooth_rms_v", r.smooth_rms_v},  {"steps_rms_v", one.steps_rms_v}};
}

}  // namespace

std::string labelOf(const CatalogueDraft& draft, const Simulation& simulation) {
  Json label = headOf(draft.order, draft.order.what.id, draft.scenario,
                      draft.scenario.acquisition.sample_rate_hz);
  label["quiet"] = draft.order.quiet;
  label["structure"] = draft.structure;
  label["strength"] = draft.strength;
  label["strength"]["scale"] = draft.order.scale;
  label["expected"] = expectedOf(draft);
  label["truth"] = truthOf(draft, simulation);
  if (draft.regime_from) label["regime_from_s"] = *draft.regime_from;
  return label.dump(2) + "\n";
}

std::string labelOf(const LawScenario& one) {
  Json label = headOf(one.order, nameOr(one.order.what.id), one.scenario, *one.order.rate);
  label.update({{"mechanism", nameOr(one.order.what.mechanism)},
                {"drive", one.order.drive},
                {"attempt", one.attempt},
                {"strength", one.strength},
                {"scale", one.order.scale.front()},
                {"rms_v", jsonOf(one.size.plain)},
                {"visible_rms_v", jsonOf(one.size.visible)},
                {"crank_v", one.size.crank_v},
                {"noise", noiseOf(one)},
                {"base", baseOf(one.scenario.battery)},
                {"voltage_limit_v", one.scenario.voltage_limit},
                {"recorder", recorderOf(one)}});
  return label.dump(2) + "\n";
}

}  // namespace battery_sof_simulator
