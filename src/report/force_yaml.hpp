#pragma once

#include "battery_sof/model/learned_force.hpp"
#include "yaml_reader.hpp"

namespace battery_sof {

/// A learnt force as MODEL.yaml holds it: columns as rows of numbers with their units, the circuit's change, factors' deviations.
YAML::Node forceNode(const LearnedForce& force);

/// @throws ModelFileError naming the field, what was found and what was expected.
LearnedForce forceOf(const Reader& node);

}  // namespace battery_sof
