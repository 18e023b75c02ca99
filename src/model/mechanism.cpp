#include "model/mechanism.hpp"

#include <stdexcept>

#include "util/text.hpp"

namespace battery_sof {
namespace {

struct MechanismInfo {
  Mechanism mechanism;
  const char* id;
  const char* sentence;
  std::vector<std::string> members;
};

/// In the order of Mechanism.
const std::vector<MechanismInfo>& table() {
  static const std::vector<MechanismInfo> all = {
      {Mechanism::kAcceptance,
       "acceptance",
       "charging is limited by how fast the battery takes charge up",
       {"charge_acceptance", "sulphate_history", "fresh_sulphate", "acceptance_soc"}},
      {Mechanism::kSideReactions,
       "side_reactions",
       "part of the charging current leaves no charge in the battery",
       {"gassing"}},
      {Mechanism::kAcid,
       "acid",
       "acid moves slowly between pores, plates and separator",
       {"acid_transport", "high_rate_depletion"}},
      {Mechanism::kOpenCircuit,
       "open_circuit",
       "open-circuit voltage and resistance depend on the charge and on its history",
       {"ocv_soc", "resistance_soc", "end_of_discharge", "surface_charge", "ocv_hysteresis",
        "coup_de_fouet"}},
      {Mechanism::kStructure,
       "structure",
       "resistance, double layer or kinetics differ from the base circuit's",
       {"cpe2", "fast_arc", "current_dependent_resistance", "charge_transfer", "second_electrode"}},
      {Mechanism::kAgeing,
       "ageing",
       "the battery's parameters change with time or temperature",
       {"self_heating", "parameter_drift"}},
      {Mechanism::kInstrument,
       "instrument",
       "the sensors or the wiring explain it",
       {"inductance", "parasitic_load", "current_offset", "current_gain", "time_skew", "sensor_lag",
        "contact_resistance", "voltage_drift", "clipping", "dropouts", "quantisation", "aliasing"}},
  };
  return all;
}

const MechanismInfo& infoOf(Mechanism mechanism) {
  return table()[static_cast<std::size_t>(mechanism)];
}

}  // namespace

std::string mechanismId(Mechanism mechanism) { return infoOf(mechanism).id; }

std::string mechanismSentence(Mechanism mechanism) { return infoOf(mechanism).sentence; }

bool isOfLeadAcid(Mechanism mechanism) {
  return mechanism == Mechanism::kAcceptance || mechanism == Mechanism::kSideReactions ||
         mechanism == Mechanism::kAcid;
}

Mechanism mechanismOf(const std::string& effect) {
  for (const MechanismInfo& info : table())
    if (contains(info.members, effect)) return info.mechanism;
  throw std::invalid_argument("effect '" + effect + "' belongs to no mechanism");
}

std::vector<std::string> namesOf(Mechanism mechanism) { return infoOf(mechanism).members; }

}  // namespace battery_sof
