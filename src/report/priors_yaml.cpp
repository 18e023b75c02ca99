#include "report/priors_yaml.hpp"

#include <algorithm>
#include <map>

#include "model/battery_model.hpp"
#include "yaml_fields.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kLargestPriors = 16 << 20;  // [bytes], thousands of types
constexpr Range kStds{1e-9, 1e9};

KnownParameter parameterOf(const ParameterInfo& info, const FieldReader& file) {
  KnownParameter known{info.name, 0.0, 0.0, false};
  file.number("value", known.value, {info.lower, info.upper});
  file.number("std", known.std, kStds);
  file.flag("logarithmic", known.logarithmic);
  file.require(!known.logarithmic || known.value > 0.0, "value",
               "is not positive, and is the mean of logarithms");
  return known;
}

BatteryModel modelOf(const FieldReader& file, const std::vector<std::string>& effects) {
  try {
    return BatteryModel(effects);
  } catch (const std::invalid_argument& error) {
    file.fail("effects", std::string("are not those of a model: ") + error.what());
  }
}

KnownPopulation populationOf(const FieldReader& file) {
  KnownPopulation population;
  file.texts("effects", population.effects, "a list of ids");
  std::sort(population.effects.begin(), population.effects.end());
  const BatteryModel model = modelOf(file, population.effects);
  file.map("parameters", [&](const FieldReader& parameters) {
    if (!parameters.node().IsMap()) file.fail("parameters", "is not a map of names");
    for (const ParameterInfo& info : model.parameters())
      if (parameters.has(info.name))
        parameters.map(info.name, [&](const FieldReader& one) {
          population.parameters.push_back(parameterOf(info, one));
        });
  });
  return population;
}

}  // namespace

std::vector<KnownPopulation> parsePriorsYaml(const std::string& text, const std::string& source,
                                             const std::string& vehicle_type) {
  const FieldReader file(documentOf(text, source), source);
  if (const std::string schema = file.text("schema"); schema != kPriorsSchema)
    file.fail("schema", "is \"" + schema + "\", expected " + kPriorsSchema);
  std::map<std::vector<std::string>, KnownPopulation> of_all, of_type;
  const auto none = [](std::size_t) {};
  file.list("priors", 0, none, [&](const FieldReader& entry, std::size_t) {
    const std::string type = entry.text("vehicle_type");
    KnownPopulation population = populationOf(entry);
    if (!type.empty() && type != vehicle_type) return;
    const bool is_new =
        (type.empty() ? of_all : of_type).emplace(population.effects, population).second;
    entry.require(is_new, "effects", "are those of an entry before it, of the same type");
  });
  file.refuseOthers();
  of_type.merge(of_all);
  std::vector<KnownPopulation> populations;
  for (auto& [effects, population] : of_type) populations.push_back(std::move(population));
  if (populations.empty())
    file.fail("priors", vehicle_type.empty()
                            ? "has no entry of all types of vehicle, and no type was given"
                            : "has no entry of the type \"" + vehicle_type +
                                  "\" nor of all types of vehicle");
  return populations;
}

std::vector<KnownPopulation> readPriorsFile(const std::filesystem::path& path,
                                            const std::string& vehicle_type) {
  return parsePriorsYaml(textOfFile(path, kLargestPriors), path.string(), vehicle_type);
}

}  // namespace battery_sof
