#include "report/change_results.hpp"

#include <nlohmann/json.hpp>
#include <optional>

#include "battery_sof/version.hpp"
#include "descriptions.hpp"
#include "util/text.hpp"
#include "wording.hpp"

namespace battery_sof {
namespace {

nlohmann::json namesJson(const std::vector<std::string>& names) {
  nlohmann::json json = nlohmann::json::array();
  for (const std::string& name : names) json.push_back(printable(name));
  return json;
}

std::string shareText(const std::optional<double>& share) {
  return share ? format("%.0f %%", *share) : "-";
}

std::string changesText(const ChangeDiagnosis& diagnosis) {
  std::string text;
  for (const Change& change : diagnosis.changes) {
    text += format("\n%-20s %12s %12s %28s %12s\n", "change", "then", "now", "90 % interval",
                   "probability");
    const std::string interval = changeStrengthText(change.lower, change.unit) + " to " +
                                 changeStrengthText(change.upper, change.unit);
    text += format("%-20s %12s %12s %28s %12.2f\n", change.id.c_str(),
                   changeStrengthText(change.then, change.unit).c_str(),
                   changeStrengthText(change.now, change.unit).c_str(), interval.c_str(),
                   change.probability);
    if (!change.indistinguishable.empty())
      text += wrapped("indistinguishable from  ", join(change.indistinguishable));
  }
  return text;
}

std::string comparedText(const ChangeDiagnosis& diagnosis) {
  if (diagnosis.compared.empty()) return "";
  std::string text = format("\n%-22s %12s %12s %12s %16s\n", "compared", "then", "now",
                            "std. error", "between trips");
  for (const ComparedFeature& one : diagnosis.compared)
    text += format("%-22s %12s %12s %12s %16s\n", one.id.c_str(),
                   changeValueText(one.then, one.unit).c_str(),
                   changeValueText(one.now, one.unit).c_str(),
                   changeValueText(one.std_error, one.unit).c_str(),
                   changeValueText(one.spread, one.unit).c_str());
  return text;
}

std::string modelsText(const ChangeDiagnosis& diagnosis) {
  std::string text;
  for (const auto& [name, share] : {std::pair("reference", &diagnosis.reference_model),
                                    {"reference with change", &diagnosis.changed_model},
                                    {"fitted to what precedes", &diagnosis.own_model}})
    if (share->share_percent)
      text += format("%-24s %12s %12s %12s\n", name, shareText(share->share_percent).c_str(),
                     shareText(share->current_share_percent).c_str(),
                     shareText(share->voltage_share_percent).c_str());
  if (text.empty()) return "";
  return format("\n%-24s %12s %12s %12s\n", "last quarter explained", "together", "current",
                "voltage") +
         text;
}

std::string limitsText(const ChangeDiagnosis& diagnosis) {
  if (diagnosis.detection_limits.empty()) return "";
  std::vector<std::string> limits;
  for (const ChangeLimit& limit : diagnosis.detection_limits)
    limits.push_back(limit.id + " " + changeStrengthText(limit.strength, limit.unit));
  return "\n" + wrapped("detected from  ", join(limits));
}

}  // namespace

std::string changeValueText(double value, const std::string& unit) {
  if (unit == "ohm") return format("%.2f mOhm", 1e3 * value);
  return unit == "1" ? format("%.3f", value) : format("%.2f %s", value, unit.c_str());
}

std::string changeStrengthText(double value, const std::string& unit) {
  return unit == "1" ? format("%.1f %%", 1e2 * value) : changeValueText(value, unit);
}

DESCRIBED(ModelShare, MEMBERS("", share_percent, current_share_percent, voltage_share_percent))

DESCRIBED(ComparedFeature, MEMBERS("", id, unit, then, now, with_change, std_error, spread))

DESCRIBED(ChangeLimit, MEMBERS("", id, strength, unit))

nlohmann::json resultJson(const ChangeDiagnosis& diagnosis,
                          const std::vector<std::string>& recordings,
                          const std::vector<std::string>& references) {
  nlohmann::json changes = nlohmann::json::array();
  for (const Change& change : diagnosis.changes) {
    JsonFields row;
    row("id", change.id);
    row("kind", std::string(change.is_effect ? "effect" : "parameter"));
    row("mechanism", change.mechanism);
    row("then", change.then);
    row("now", change.now);
    row("unit", change.unit);
    row("interval", std::vector<double>{change.lower, change.upper});
    row("probability", change.probability);
    row("indistinguishable", change.indistinguishable);
    changes.push_back(row.json);
  }
  JsonFields visit;
  visit("schema", "battery_sof/change/1");
  visit("program", "battery_sof " + version());
  visit("recordings", namesJson(recordings));
  visit("references", namesJson(references));
  visit("verdict", toString(diagnosis.verdict));
  visit("summary", diagnosis.summary);
  visit("changes", changes);
  visit("explained",
        nlohmann::json{{"reference_model", jsonOf(diagnosis.reference_model)},
                       {"changed_model", jsonOf(diagnosis.changed_model)},
                       {"own_model", jsonOf(diagnosis.own_model)},
                       {"distance", jsonOf(diagnosis.distance)},
                       {"gain", jsonOf(diagnosis.gain)},
                       {"model_distance", jsonOf(diagnosis.model_distance)},
                       {"largest_model_distance", jsonOf(diagnosis.largest_model_distance)}});
  visit("compared", diagnosis.compared);
  visit("detection_limits", diagnosis.detection_limits);
  return visit.json;
}

std::string resultText(const ChangeDiagnosis& diagnosis) {
  return wrapped("verdict      ", toString(diagnosis.verdict)) +
         wrapped("summary      ", diagnosis.summary) + changesText(diagnosis) +
         comparedText(diagnosis) + modelsText(diagnosis) + limitsText(diagnosis);
}

}  // namespace battery_sof
