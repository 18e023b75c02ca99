#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/base_model.hpp"

namespace battery_sof {

/// A state that an effect adds to the model.
struct StateInfo {
  std::string name;   ///< code name, unique among all effects
  std::string unit;   ///< "V", "A", "1", "Ah", "K"
  double rest = 0.0;  ///< value in a battery that rested for long
  /// Standard deviation of the value where a recording begins, in unit: the value is then estimated
  /// with the parameters. None: every recording is taken to begin at rest.
  std::optional<double> initial_std = std::nullopt;
  double lower = -1e9, upper = 1e9;  ///< bounds of the value where a recording begins, in unit
  bool begins_as_u_c2 = false;       ///< starts at u_c2's first value: a part of the double layer
};

/**
 * @brief One further piece of physics, or of the instruments, as a reader needs to know it
 * (docs/physics.md).
 *
 * The equations themselves stand in src/model/effects/<id>.cpp, one file an effect, and nowhere
 * else: simulation, derivatives, fit, prediction, diagnosis and reports all read that file.
 */
struct EffectInfo {
  std::string id;         ///< as in JSON, YAML and messages
  std::string code;       ///< S1 to S6, P1 to P13, I1 to I9; the letter is the tier
  std::string title;      ///< a few words
  std::string equations;  ///< plain text, one equation a line
  std::vector<ParameterInfo> parameters;
  std::vector<StateInfo> states;
  std::vector<std::string> look_alikes;  ///< ids it is often confused with
  std::string distinguished_by;          ///< the recording that separates it from them
  std::vector<std::string> needs = {};   ///< ids without which it has no meaning
  /// parameters in which the voltage is not linear once this effect is there
  std::vector<std::string> is_nonlinear = {};
  /// ids that current and voltage at 100 Hz do not tell it from, whatever a fit says
  std::vector<std::string> same_as = {};
  /// Base parameters as they are with this effect: magnitude, bounds and what is known
  /// beforehand.
  std::vector<ParameterInfo> overrides = {};
  /// within a tenth of a second of a change of the current, and nowhere else
  bool acts_at_edges = false;
  /// long intervals cost as many short ones: the effect acts back on others within them
  /// a diagnosis weighs it only where it is named among the hypotheses
  bool on_request = false;
  char tier() const { return code.front(); }
};

/// @return every effect that can be composed with the base model, in the order in which they are
/// applied.
const std::vector<EffectInfo>& effectCatalogue();

/// @return ids in the catalogue's order: what is given is one set, however it was written.
std::vector<std::string> inCatalogueOrder(const std::vector<std::string>& ids);

/// @return the effect of the catalogue; nullptr where it cannot be composed (clipping, dropouts).
const EffectInfo* catalogued(const std::string& id);
/// @return its title there; the id where there is none.
std::string titleOf(const std::string& id);
/// @throws std::invalid_argument naming the id and all known ones.
const EffectInfo& effectInfo(const std::string& id);

}  // namespace battery_sof
