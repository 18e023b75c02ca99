#include "simulator/case_catalogue.hpp"

#include <algorithm>
#include <set>

namespace battery_sof_reference {
namespace {

using Names = std::vector<std::string>;

const Names kStructure{
    "cpe2",      "fast_arc", "current_dependent_resistance", "charge_transfer", "second_electrode",
    "inductance"};
const Names kChemistry{"gassing", "charge_acceptance", "sulphate_history",   "acid_transport",
                       "ocv_soc", "ocv_hysteresis",    "high_rate_depletion"};
const Names kOtherPhysics{"coup_de_fouet", "self_heating", "parameter_drift", "parasitic_load"};
const Names kInstrument{
    "current_offset",     "current_gain", "time_skew", "sensor_lag",    "quantisation",
    "contact_resistance", "clipping",     "dropouts",  "voltage_drift", "aliasing"};
const Names kUnlisted{"memory_resistance", "step_force", "gated_tone",
                      "capacitance_fall",  "dead_zone",  "hysteretic_r"};
const Names kMasked{"charge_acceptance+gassing", "charge_acceptance+current_gain",
                    "ocv_soc+voltage_drift", "current_dependent_resistance+time_skew"};
const Names kAbsent{"charge_acceptance", "gassing", "high_rate_depletion", "acid_transport"};

constexpr double kUsualDuration = 1200.0, kUsualAbsentDuration = 2400.0;  // [s]

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

void append(std::vector<CaseKind>& kinds, const std::string& mechanism, const Names& ids) {
  for (const auto& id : ids) kinds.push_back({mechanism, id});
}

Names tiesOf(const Names& effects) {
  std::set<std::string> ties;
  for (const auto& tied : kTieClasses) {
    const bool concerned = std::any_of(tied.begin(), tied.end(), [&](const std::string& id) {
      return std::count(effects.begin(), effects.end(), id) > 0;
    });
    if (concerned) ties.insert(tied.begin(), tied.end());
  }
  for (const auto& effect : effects) ties.erase(effect);
  for (const auto& id : kUnlisted) ties.erase(id);
  return {ties.begin(), ties.end()};
}

Names verdictsOf(const CaseKind& kind) {
  if (kind.mechanism == "null") return {"no_mismatch"};
  if (kind.mechanism == "structural_null" || kind.mechanism == "porous_null")
    return {"no_mismatch", "named", "several", "ambiguous", "unknown"};
  if (kind.mechanism == "unknown") return {"unknown"};
  if (kind.mechanism != "decoy") return {"named", "several", "ambiguous"};
  if (kind.id == "quantisation" || kind.id == "dropouts")
    return {"no_mismatch", "sensor_fault", "insufficient_data"};
  return {"sensor_fault", "named", "ambiguous"};
}

}  // namespace

const std::vector<CaseKind>& caseKinds() {
  static const std::vector<CaseKind> kinds = [] {
    std::vector<CaseKind> all{{"null", "-"}, {"structural_null", "-"}, {"porous_null", "-"}};
    for (const Names* tier : {&kStructure, &kChemistry, &kOtherPhysics})
      append(all, "effect", *tier);
    append(all, "decoy", kInstrument);
    append(all, "unknown", kUnlisted);
    append(all, "structural_effect", kChemistry);
    append(all, "porous_effect", {"charge_acceptance", "acid_transport", "gassing"});
    append(all, "masked", kMasked);
    append(all, "absent", kAbsent);
    return all;
  }();
  return kinds;
}

std::vector<std::string> additionsOf(const CaseKind& kind) {
  if (kind.id == "-") return {};
  const auto plus = kind.id.find('+');
  if (plus == std::string::npos) return {kind.id};
  return {kind.id.substr(0, plus), kind.id.substr(plus + 1)};
}

double usualDuration(const CaseKind& kind) {
  return kind.mechanism == "absent" ? kUsualAbsentDuration : kUsualDuration;
}

CaseKind nestedKind(const CaseKind& kind, const std::vector<std::string>& effects) {
  const bool companion = std::count(effects.begin(), effects.end(), "charge_acceptance") > 0;
  if (companion) return kind;
  if (kind.mechanism == "structural_effect") return {"structural_null", "-"};
  if (kind.mechanism == "porous_effect") return {"porous_null", "-"};
  return {"null", "-"};
}

Expectation expectationOf(const CaseKind& kind, const std::vector<std::string>& effects) {
  const bool unlisted = kind.mechanism == "unknown";
  Expectation expected{verdictsOf(kind), effects, tiesOf(unlisted ? Names{kind.id} : effects)};
  if (kind.id == "capacitance_fall") expected.verdicts.push_back("named");
  return expected;
}

}  // namespace battery_sof_reference
