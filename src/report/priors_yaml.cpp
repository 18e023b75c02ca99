#include "report/priors_yaml.hpp"

#include <algorithm>
#include <map>

#include "yaml_fields.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kLargestPriors = 16 << 20;  // [bytes], thousands of types
constexpr Range kStds{1e-9, 1e9};

KnownParameter parameterOf(const std::string& name, const FieldReader& file) {
  KnownParameter known{name, 0.0, 0.0, false};
  file.number("value", known.value, kNumbers);
  file.number("std", known.std, kStds);
  file.flag("logarithmic", known.logarithmic);
  file.require(!known.logarithmic || known.value > 0.0, "value",
               "is not positive, and is the mean of logarithms");
  return known;
}

KnownPopulation populationOf(const FieldReader& file) {
  KnownPopulation population;
  file.texts("effects", population.effects, "a list of ids");
  std::sort(population.effects.begin(), population.effects.end());
  file.map("parameters", [&](const FieldReader& parameters) {
    if (!parameters.node().IsMap()) file.fail("parameters", "is no map of names");
    for (const auto& entry : parameters.node()) {
      const std::string name = entry.first.as<std::string>();
      parameters.map(name, [&](const FieldReader& one) {
        population.parameters.push_back(parameterOf(name, one));
      });
    }
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
    if (!type.empty() && type != vehicle_type) return;
    KnownPopulation population = populationOf(entry);
    (type.empty() ? of_all : of_type)[population.effects] = population;
  });
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
