#include "simulator/generator/scenario_kind.hpp"

#include <cmath>
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
const Names kBehindCharger{"fresh_sulphate"};
const Names kInstrument{
    "current_offset",     "current_gain", "time_skew", "sensor_lag",    "quantisation",
    "contact_resistance", "clipping",     "dropouts",  "voltage_drift", "aliasing"};
const Names kUnlisted{"memory_resistance", "step_force", "gated_tone",
                      "capacitance_fall",  "dead_zone",  "hysteretic_r"};
const Names kMasked{"charge_acceptance+gassing", "charge_acceptance+current_gain",
                    "ocv_soc+voltage_drift", "current_dependent_resistance+time_skew"};
const Names kAbsent{"charge_acceptance", "gassing", "high_rate_depletion", "acid_transport"};

constexpr double kUsualDuration = 1200.0, kUsualAbsentDuration = 2400.0;  // [s]

void append(std::vector<ScenarioKind>& kinds, const std::string& kind, const Names& ids) {
  for (const auto& id : ids) kinds.push_back({kind, id});
}

}  // namespace

const std::vector<ScenarioKind>& scenarioKinds() {
  static const std::vector<ScenarioKind> kinds = [] {
    std::vector<ScenarioKind> all{
        {"base_control", "-"}, {"structural_control", "-"}, {"porous_control", "-"}};
    for (const Names* tier : {&kStructure, &kChemistry, &kOtherPhysics, &kBehindCharger})
      append(all, "effect", *tier);
    append(all, "instrument_fault", kInstrument);
    append(all, kUnlistedLaw, kUnlisted);
    append(all, "structural_effect", kChemistry);
    append(all, "porous_effect", {"charge_acceptance", "acid_transport", "gassing"});
    append(all, "masked", kMasked);
    append(all, "absent", kAbsent);
    for (const char* one : {kControl, kRecorderControl, kDeepCycle}) all.push_back({one});
    for (const LawForm& law : lawForms()) all.push_back({kOutOfCatalogue, law.id, law.mechanism});
    return all;
  }();
  return kinds;
}

bool isOfCatalogue(const ScenarioKind& kind) {
  return kind.kind != kOutOfCatalogue && kind.kind != kControl && kind.kind != kRecorderControl &&
         kind.kind != kDeepCycle;
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

}  // namespace battery_sof_simulator
