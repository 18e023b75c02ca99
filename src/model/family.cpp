#include "battery_sof/model/family.hpp"

#include <algorithm>
#include <stdexcept>

#include "battery_sof/model/effect.hpp"
#include "battery_sof/recording/words.hpp"

namespace battery_sof {
namespace {

struct FamilyInfo {
  Family family;
  const char* id;
  const char* sentence;
  std::vector<std::string> members;
};

const std::vector<FamilyInfo>& table() {
  static const std::vector<FamilyInfo> all = {
      {Family::kAcceptance,
       "acceptance",
       "charging is limited by how fast the battery takes charge up",
       {"charge_acceptance", "sulphate_history", "fresh_sulphate"}},
      {Family::kSideReactions, "side_reactions", "part of the charging current leaves no charge in the battery", {"gassing"}},
      {Family::kAcid, "acid", "acid moves slowly between pores, plates and separator", {"acid_transport", "high_rate_depletion"}},
      {Family::kOpenCircuit,
       "open_circuit",
       "the open-circuit voltage moves with the charge and the way it came there",
       {"ocv_soc", "ocv_hysteresis", "coup_de_fouet"}},
      {Family::kStructure,
       "structure",
       "resistance, double layer or kinetics differ from the base circuit's",
       {"cpe2", "fast_arc", "current_dependent_resistance", "charge_transfer", "second_electrode"}},
      {Family::kAgeing, "ageing", "the battery's parameters change with time or temperature", {"self_heating", "parameter_drift"}},
      {Family::kInstrument,
       "instrument",
       "the sensors or the wiring explain it",
       {"inductance", "parasitic_load", "current_offset", "current_gain", "time_skew", "sensor_lag", "contact_resistance", "voltage_drift",
        "clipping", "dropouts", "quantisation", "aliasing"}},
  };
  return all;
}

const FamilyInfo& infoOf(Family family) {
  return *std::find_if(table().begin(), table().end(), [&](const FamilyInfo& info) { return info.family == family; });
}

}  // namespace

std::string familyId(Family family) { return infoOf(family).id; }

std::string familySentence(Family family) { return infoOf(family).sentence; }

bool isOfLeadAcid(Family family) { return family == Family::kAcceptance || family == Family::kSideReactions || family == Family::kAcid; }

Family familyOf(const std::string& effect) {
  for (const FamilyInfo& info : table())
    if (contains(info.members, effect)) return info.family;
  throw std::invalid_argument("effect '" + effect + "' belongs to no family");
}

std::vector<std::string> membersOf(Family family) {
  std::vector<std::string> ids;
  for (const EffectInfo& effect : effectCatalogue())
    if (familyOf(effect.id) == family) ids.push_back(effect.id);
  return ids;
}

std::vector<std::string> namesOf(Family family) { return infoOf(family).members; }

}  // namespace battery_sof
