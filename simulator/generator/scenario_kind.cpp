#include "simulator/generator/scenario_kind.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "simulator/fields.hpp"
#include "simulator/generator/law.hpp"

namespace battery_sof_simulator {
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

void append(std::vector<ScenarioKind>& kinds, const std::string& kind, const Names& ids) {
  for (const auto& id : ids) kinds.push_back({kind, id});
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

Names verdictsOf(const ScenarioKind& kind) {
  if (kind.kind == "base_control") return {"no_mismatch"};
  if (kind.kind == "structural_control" || kind.kind == "porous_control")
    return {"no_mismatch", "named", "several", "ambiguous", "unknown"};
  if (kind.kind == "unlisted_law") return {"unknown"};
  if (kind.kind != "instrument_fault") return {"named", "several", "ambiguous"};
  if (kind.id == "quantisation" || kind.id == "dropouts")
    return {"no_mismatch", "sensor_fault", "insufficient_data"};
  return {"sensor_fault", "named", "ambiguous"};
}

}  // namespace

const std::vector<ScenarioKind>& scenarioKinds() {
  static const std::vector<ScenarioKind> kinds = [] {
    std::vector<ScenarioKind> all{
        {"base_control", "-"}, {"structural_control", "-"}, {"porous_control", "-"}};
    for (const Names* tier : {&kStructure, &kChemistry, &kOtherPhysics})
      append(all, "effect", *tier);
    append(all, "instrument_fault", kInstrument);
    append(all, "unlisted_law", kUnlisted);
    append(all, "structural_effect", kChemistry);
    append(all, "porous_effect", {"charge_acceptance", "acid_transport", "gassing"});
    append(all, "masked", kMasked);
    append(all, "absent", kAbsent);
    for (const char* control : {kControl, kRecorderControl}) all.push_back({control});
    for (const LawForm& law : lawForms()) all.push_back({kOutOfCatalogue, law.id, law.mechanism});
    return all;
  }();
  return kinds;
}

bool isOfCatalogue(const ScenarioKind& kind) {
  return kind.kind != kOutOfCatalogue && kind.kind != kControl && kind.kind != kRecorderControl;
}

std::vector<ScenarioKind> meantBy(const ScenarioKind& asked) {
  // A catalogue kind that has ids is meant with one; of laws the seed may choose.
  const bool exact = isOfCatalogue(asked);
  const auto fits = [&](const std::string& word, const std::string& of) {
    return word == of || (word.empty() && (!exact || of == "-"));
  };
  std::vector<ScenarioKind> meant;
  for (const ScenarioKind& one : scenarioKinds())
    if (one.kind == asked.kind && fits(asked.id, one.id) && fits(asked.mechanism, one.mechanism))
      meant.push_back(one);
  if (!meant.empty()) return meant;
  std::string words = asked.kind;
  for (const std::string& word : {asked.mechanism, asked.id})
    if (!word.empty() && word != "-") words += " " + word;
  throw std::invalid_argument("nothing is \"" + words + "\"; --list names what there is");
}

void requireSound(const Order& order, double shortest, double longest) {
  for (double scale : order.scale)
    if (!std::isfinite(scale) || scale < 0.0)
      throw std::invalid_argument(faultOf("scale", scale, "0 or more"));
  if (!order.duration || (*order.duration >= shortest && *order.duration <= longest)) return;
  throw std::invalid_argument("duration is " + std::to_string(*order.duration) + " s, expected " +
                              std::to_string(std::lround(shortest)) + " to " +
                              std::to_string(std::lround(longest)));
}

std::vector<std::string> additionsOf(const ScenarioKind& kind) {
  if (kind.id == "-") return {};
  const auto plus = kind.id.find('+');
  if (plus == std::string::npos) return {kind.id};
  return {kind.id.substr(0, plus), kind.id.substr(plus + 1)};
}

double usualDuration(const ScenarioKind& kind) {
  return kind.kind == "absent" ? kUsualAbsentDuration : kUsualDuration;
}

ScenarioKind nestedKind(const ScenarioKind& kind, const std::vector<std::string>& effects) {
  const bool companion = std::count(effects.begin(), effects.end(), "charge_acceptance") > 0;
  if (companion) return kind;
  if (kind.kind == "structural_effect") return {"structural_control", "-"};
  if (kind.kind == "porous_effect") return {"porous_control", "-"};
  return {"base_control", "-"};
}

Expectation expectationOf(const ScenarioKind& kind, const std::vector<std::string>& effects) {
  const bool unlisted = kind.kind == "unlisted_law";
  Expectation expected{verdictsOf(kind), effects, tiesOf(unlisted ? Names{kind.id} : effects)};
  if (kind.id == "capacitance_fall") expected.verdicts.push_back("named");
  return expected;
}

}  // namespace battery_sof_simulator
