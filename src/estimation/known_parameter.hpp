#pragma once

#include <string>
#include <vector>

namespace battery_sof {

/// What other batteries say of a parameter before this one is measured, in place of the catalogue's
/// prior.
struct KnownParameter {
  std::string name;
  double value = 0.0;  ///< in the parameter's unit
  /// of the logarithm when logarithmic, else in the parameter's unit; > 0
  double std = 0.0;
  bool logarithmic = false;  ///< then value is the geometric mean
};

/// What a population says, of fits with the same effects.
struct KnownPopulation {
  std::vector<std::string> effects;  ///< ids, in any order
  std::vector<KnownParameter> parameters;
};

/// @return what is known of a composition's parameters: of the population of exactly these effects,
/// in any order; empty without one.
std::vector<KnownParameter> knownOf(const std::vector<KnownPopulation>& populations,
                                    std::vector<std::string> effects);

/// @return what is known of a parameter; nullptr: nothing.
const KnownParameter* find(const std::vector<KnownParameter>& known, const std::string& name);

}  // namespace battery_sof
