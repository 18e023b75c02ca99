#include "estimation/known_parameter.hpp"

#include <algorithm>

namespace battery_sof {

std::vector<KnownParameter> knownOf(const std::vector<KnownPopulation>& populations,
                                    std::vector<std::string> effects) {
  std::sort(effects.begin(), effects.end());
  for (const KnownPopulation& population : populations) {
    std::vector<std::string> of_population = population.effects;
    std::sort(of_population.begin(), of_population.end());
    if (of_population == effects) return population.parameters;
  }
  return {};
}

const KnownParameter* find(const std::vector<KnownParameter>& known, const std::string& name) {
  const auto one = std::find_if(known.begin(), known.end(), [&](const KnownParameter& parameter) {
    return parameter.name == name;
  });
  return one == known.end() ? nullptr : &*one;
}

}  // namespace battery_sof
