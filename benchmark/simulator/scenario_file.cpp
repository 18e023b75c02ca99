#include "simulator/scenario_file.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <type_traits>

#include "simulator/fields.hpp"

namespace battery_sof_simulator {
namespace {

using Faults = std::vector<std::string>;

/// Whether a node is a value of that type, which is then taken over.
template <typename Value>
bool convert(const YAML::Node& node, Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    const auto names = namesOf(value);
    const auto name = std::find(names.begin(), names.end(), node.IsScalar() ? node.Scalar() : "");
    if (name != names.end()) value = static_cast<Value>(name - names.begin());
    return name != names.end();
  } else if constexpr (std::is_same_v<Value, Range>) {
    return node.IsSequence() && node.size() == 2 && convert(node[0], value.low) &&
           convert(node[1], value.high);
  } else {
    Value read{};
    const bool is_one = YAML::convert<Value>::decode(node, read);
    if (is_one) value = read;
    return is_one;
  }
}

std::string shown(const YAML::Node& node) {
  return node.IsScalar() ? "\"" + node.Scalar() + "\"" : "not a single value";
}

/// What a key's value has to be, for messages.
std::string expected(double) { return "a number"; }
std::string expected(int) { return "a whole number"; }
std::string expected(std::uint64_t) { return "a whole number, 0 or more"; }
std::string expected(bool) { return "true or false"; }
std::string expected(const std::string&) { return "a name"; }
std::string expected(const Range&) { return "two numbers [low, high]"; }
template <typename Enum>
std::string expected(Enum value) {
  const auto names = namesOf(value);
  std::string text = names.front();
  for (std::size_t k = 1; k < names.size(); ++k)
    text += (k + 1 < names.size() ? ", " : " or ") + names[k];
  return text;
}

/// Takes values out of one YAML map; bounds are checked by faultsOf().
class MapReader {
 public:
  MapReader(const YAML::Node& map, std::string prefix, Faults& faults)
      : map_(map), prefix_(std::move(prefix)), faults_(faults) {
    if (map_.IsDefined() && !map_.IsMap() && !map_.IsNull())
      faults_.push_back(prefix_ + " is " + shown(map_) + ", expected a map");
  }

  template <typename Value>
  void read(const std::string& key, Value& value) {
    const YAML::Node node = find(key);
    if (node.IsDefined() && !convert(node, value))
      refuse(key, std::is_same_v<Value, Range> ? "something else" : shown(node), expected(value));
  }
  void read(const Fields& fields) {
    for (const Field& field : fields)
      std::visit([&](auto* place) { read(field.key, *place); }, field.place);
  }

  /// @return the node of a key, undefined when it is left out.
  YAML::Node find(const std::string& key) {
    known_.insert(key);
    return map_.IsMap() ? map_[key] : YAML::Node(YAML::NodeType::Undefined);
  }
  void refuse(const std::string& key, const std::string& is, const std::string& expected) {
    faults_.push_back(nameOf(key) + " is " + is + ", expected " + expected);
  }
  std::string nameOf(const std::string& key) const {
    return prefix_.empty() ? key : prefix_ + "." + key;
  }

  /// Called after all fields were visited.
  void refuseUnknownKeys() {
    if (!map_.IsMap()) return;
    std::set<std::string> seen;
    for (const auto& entry : map_) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "(not a name)";
      if (known_.count(key) == 0) faults_.push_back(nameOf(key) + " is not a known key");
      if (!seen.insert(key).second) faults_.push_back(nameOf(key) + " is given twice");
    }
  }

 private:
  YAML::Node map_;
  std::string prefix_;
  Faults& faults_;
  std::set<std::string> known_;
};

template <typename Options>
void readMap(const YAML::Node& node, const std::string& prefix, Faults& faults, Options& options) {
  MapReader reader(node, prefix, faults);
  reader.read(fieldsOf(options));
  reader.refuseUnknownKeys();
}

Phase readPhase(const YAML::Node& node, const std::string& prefix, Faults& faults) {
  Phase phase{0.0, 0.0, 0.0};
  readMap(node, prefix, faults, phase);
  if (!node.IsMap() || !node["duration_s"]) faults.push_back(prefix + ".duration_s is missing");
  if (!node.IsMap() || !node["current_a"]) faults.push_back(prefix + ".current_a is missing");
  if (node.IsMap() && !node["to_current_a"]) phase.end = phase.begin;
  return phase;
}

ListedPhases readListedPhases(MapReader& reader, Faults& faults) {
  ListedPhases listed;
  const YAML::Node node = reader.find("phases");
  if (!node.IsDefined() || !node.IsSequence()) {
    reader.refuse("phases", "missing or not a list", "a list of phases");
    return listed;
  }
  for (std::size_t k = 0; k < node.size(); ++k)
    listed.phases.push_back(
        readPhase(node[k], reader.nameOf("phases[" + std::to_string(k) + "]"), faults));
  return listed;
}

ProfileOptions readProfile(const YAML::Node& node, Faults& faults) {
  MapReader reader(node, "profile", faults);
  const ProfileOptions usual[] = {AlternatingOptions{}, LongChargesOptions{}, CityOptions{},
                                  ListedPhases{}};
  const YAML::Node kind = reader.find("kind");
  const std::string name = kind.IsDefined() && kind.IsScalar() ? kind.Scalar() : "missing";
  const auto* const found = std::find(kProfileKinds.begin(), kProfileKinds.end(), name);
  if (found == kProfileKinds.end()) {
    reader.refuse("kind", name, "alternating, long_charges, city_drive or phases");
    return {};
  }
  ProfileOptions profile = usual[found - kProfileKinds.begin()];
  std::visit([&](auto& options) { reader.read(fieldsOf(options)); }, profile);
  if (name == "phases") profile = readListedPhases(reader, faults);
  reader.refuseUnknownKeys();
  return profile;
}

std::vector<Insert> readInserts(MapReader& root, Faults& faults) {
  std::vector<Insert> inserts;
  const YAML::Node node = root.find("inserts");
  if (!node.IsDefined()) return inserts;
  if (!node.IsSequence()) root.refuse("inserts", shown(node), "a list of {at_s, phases}");
  for (std::size_t k = 0; node.IsSequence() && k < node.size(); ++k) {
    MapReader reader(node[k], "inserts[" + std::to_string(k) + "]", faults);
    Insert insert;
    reader.read("at_s", insert.at);
    insert.phases = readListedPhases(reader, faults).phases;
    reader.refuseUnknownKeys();
    inserts.push_back(insert);
  }
  return inserts;
}

Scenario readScenario(const YAML::Node& root, Faults& faults) {
  Scenario scenario;
  MapReader reader(root, "", faults);
  reader.read("name", scenario.name);
  reader.read("seed", scenario.seed);
  reader.read("duration_s", scenario.duration);
  reader.read("voltage_limit_v", scenario.voltage_limit);
  reader.read("slew_a_per_s", scenario.slew);
  reader.read("soc", scenario.start.soc);
  reader.read("temperature_degc", scenario.start.temperature);
  reader.read("impedance_current_a", scenario.impedance_current);
  readMap(reader.find("battery"), "battery", faults, scenario.battery);
  readMap(reader.find("effects"), "effects", faults, scenario.effects);
  readMap(reader.find("additions"), "additions", faults, scenario.additions);
  readMap(reader.find("acquisition"), "acquisition", faults, scenario.acquisition);
  scenario.profile = readProfile(reader.find("profile"), faults);
  scenario.inserts = readInserts(reader, faults);
  reader.refuseUnknownKeys();
  const Faults values = faultsOf(scenario);
  faults.insert(faults.end(), values.begin(), values.end());
  return scenario;
}

}  // namespace

Scenario parseScenario(const std::string& text, const std::string& source) {
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw ScenarioError(source + ": not readable as YAML: " + error.what());
  }
  if (!root.IsMap()) throw ScenarioError(source + ": expected a map of keys and values");
  Faults faults;
  const Scenario scenario = readScenario(root, faults);
  if (faults.empty()) return scenario;
  throw ScenarioError(source + ": " + join(faults));
}

Scenario loadScenario(const std::filesystem::path& path) {
  if (std::filesystem::exists(path) && !std::filesystem::is_regular_file(path))
    throw ScenarioError(path.string() + ": is not a regular file");
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file.is_open() || file.bad()) throw ScenarioError(path.string() + ": cannot be read");
  return parseScenario(text, path.string());
}

}  // namespace battery_sof_simulator
