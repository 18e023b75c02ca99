#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/explanation.hpp"
#include "estimation/identification.hpp"
#include "stage_prepare.hpp"

namespace battery_sof {

/// Mechanisms and effects that represent the base circuit's errors, in the direction that is
/// controlled.
struct Explained {
  /// a charger that controls the voltage
  std::optional<ChargerControl> driving;
  Explanation explanation;
  bool is_lead_acid = true;        ///< the voltage is that of blocks of six lead-acid cells
  std::vector<std::string> notes;  ///< on what was not weighed, a sentence each
  bool hasEffects() const { return !explanation.model.effects().empty(); }
};

/// @return what the training part says for each mechanism with the current as its input: whether a
/// source is taken to control the voltage hangs on little.
MechanismEvidence weighMechanisms(const Prepared& prepared, const DiagnoseOptions& options);

Explained explainErrors(const Prepared& prepared, const DiagnoseOptions& options);

}  // namespace battery_sof
