#include "simulator/case_label.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "simulator/fields.hpp"

namespace battery_sof_reference {
namespace {

using Json = nlohmann::json;
constexpr double kSecondsPerHour = 3600.0;

/// A visitor of fields that writes their values down.
class FieldWriter {
 public:
  void number(const std::string& key, double value, double, double) { json_[key] = value; }
  void count(const std::string& key, int value, int, int) { json_[key] = value; }
  void range(const std::string& key, const Range& range, double, double) {
    json_[key] = {range.low, range.high};
  }
  void flag(const std::string& key, bool value) { json_[key] = value; }
  template <typename Enum, std::size_t size>
  void choice(const std::string& key, Enum value, const std::array<Choice<Enum>, size>& choices) {
    for (const auto& choice : choices)
      if (choice.value == value) json_[key] = choice.name;
  }
  const Json& json() const { return json_; }

 private:
  Json json_ = Json::object();
};

template <typename Options>
Json jsonOf(Options options) {
  FieldWriter writer;
  visitFields(writer, options);
  return writer.json();
}

Json jsonOf(const ListedPhases& listed) {
  Json phases = Json::array();
  for (const Phase& phase : listed.phases) phases.push_back(jsonOf<Phase>(phase));
  return {{"phases", phases}};
}

Json profileOf(const ProfileOptions& profile) {
  const std::array<const char*, 4> kinds{"alternating", "long_charges", "city_drive", "phases"};
  Json json = std::visit([](const auto& options) { return jsonOf(options); }, profile);
  json["kind"] = kinds[profile.index()];
  return json;
}

Json insertsOf(const std::vector<Insert>& inserts) {
  Json json = Json::array();
  for (const Insert& insert : inserts) {
    Json one = jsonOf(ListedPhases{insert.phases});
    one["at_s"] = insert.at;
    json.push_back(one);
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

Json strengthOf(const CaseDraft& draft) {
  Json json = draft.strength;
  json["scale"] = draft.scale;
  return json;
}

/// What may be said, also when nothing is left of what the kind adds.
Expectation expectationOf(const CaseKind& kind, const CaseDraft& draft) {
  const bool gone =
      !draft.scale.empty() && *std::max_element(draft.scale.begin(), draft.scale.end()) == 0.0;
  return expectationOf(gone ? nestedKind(kind, draft.effects) : kind, draft.effects);
}

Json truthOf(const CaseDraft& draft, const Simulation& simulation) {
  Json json = drivingTruthOf(draft.scenario, simulation);
  if (draft.porous) {
    json["porous"] = jsonOf(*draft.porous);
    return json;
  }
  json["battery"] = jsonOf(draft.scenario.battery);
  json["effects"] = jsonOf(draft.scenario.effects);
  json["additions"] = jsonOf(draft.scenario.additions);
  return json;
}

}  // namespace

std::string labelOf(const CaseKind& kind, const CaseDraft& draft, const Simulation& simulation) {
  const Expectation expected = expectationOf(kind, draft);
  Json label = {
      {"schema", "battery_sof/case/1"},
      {"family", kind.mechanism},
      {"id", kind.id},
      {"seed", draft.scenario.seed},
      {"duration_s", draft.scenario.duration},
      {"sample_rate_hz", draft.scenario.acquisition.sample_rate_hz},
      {"quiet", draft.quiet},
      {"structure", draft.structure},
      {"strength", strengthOf(draft)},
      {"expected",
       {{"verdicts", expected.verdicts}, {"effects", expected.effects}, {"ties", expected.ties}}},
      {"truth", truthOf(draft, simulation)}};
  if (draft.regime_from) label["regime_from_s"] = *draft.regime_from;
  return label.dump(2) + "\n";
}

}  // namespace battery_sof_reference
