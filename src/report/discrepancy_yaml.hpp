#pragma once

#include "model/discrepancy_model.hpp"
#include "yaml_reader.hpp"

namespace battery_sof {

/// A discrepancy model as MODEL.yaml holds it: columns as rows of numbers with their units, the
/// circuit's change, factors' deviations.
YAML::Node discrepancyNode(const DiscrepancyModel& discrepancy);

/// @throws ModelFileError naming the field, what was found and what was expected.
DiscrepancyModel discrepancyOf(const Reader& node);

}  // namespace battery_sof
