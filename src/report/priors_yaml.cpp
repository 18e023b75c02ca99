#include "report/priors_yaml.hpp"

#include <algorithm>
#include <map>

#include "util/regular_file.hpp"
#include "yaml_reader.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kLargestPriors = 16 << 20;  // [bytes], thousands of types
constexpr Range kStds{1e-9, 1e9};

KnownParameter parameterOf(const std::string& name, const Reader& reader) {
  KnownParameter known{name, reader.number("value", kNumbers), reader.number("std", kStds),
                       reader.get<bool>("logarithmic", "true or false")};
  if (known.logarithmic && known.value <= 0.0)
    reader.fail("value", "is not positive, and is the mean of logarithms");
  return known;
}

KnownPopulation populationOf(const Reader& reader) {
  KnownPopulation population;
  population.effects = reader.get<std::vector<std::string>>("effects", "a list of ids");
  std::sort(population.effects.begin(), population.effects.end());
  const Reader parameters = reader.at("parameters");
  if (!parameters.node().IsMap()) reader.fail("parameters", "is no map of names");
  for (const auto& entry : parameters.node()) {
    const std::string name = entry.first.as<std::string>();
    population.parameters.push_back(parameterOf(name, parameters.at(name)));
  }
  return population;
}

}  // namespace

std::vector<KnownPopulation> parsePriorsYaml(const std::string& text, const std::string& source,
                                             const std::string& vehicle_type) {
  YAML::Node node;
  try {
    node = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw ModelFileError(source + ": no YAML: " + error.msg);
  }
  const Reader file(node, source, "");
  if (const std::string schema = file.text("schema"); schema != kPriorsSchema)
    file.fail("schema", "is \"" + schema + "\", expected " + kPriorsSchema);
  std::map<std::vector<std::string>, KnownPopulation> of_all, of_type;
  for (const Reader& entry : file.listAt("priors")) {
    const std::string type = entry.text("vehicle_type");
    if (!type.empty() && type != vehicle_type) continue;
    KnownPopulation population = populationOf(entry);
    (type.empty() ? of_all : of_type)[population.effects] = population;
  }
  of_type.merge(of_all);
  std::vector<KnownPopulation> populations;
  for (auto& [effects, population] : of_type) populations.push_back(std::move(population));
  return populations;
}

std::vector<KnownPopulation> readPriorsFile(const std::filesystem::path& path,
                                            const std::string& vehicle_type) {
  std::string text;
  try {
    text = readRegularFile(path, kLargestPriors);
  } catch (const std::runtime_error& error) {
    throw ModelFileError(error.what());
  }
  return parsePriorsYaml(text, path.string(), vehicle_type);
}

}  // namespace battery_sof
