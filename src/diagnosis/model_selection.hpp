#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/explanation.hpp"
#include "diagnosis/residuals.hpp"
#include "estimation/identification.hpp"

namespace battery_sof {

/// Mechanisms and effects that represent the base circuit's errors, in the direction that is
/// controlled.
struct Explained {
  /// a charger that controls the voltage
  std::optional<ChargerControl> driving;
  Explanation explanation;
  /// as `sof identify --effects none` fits it to the training part; none where that has no fit and
  /// nothing is compared with it
  std::optional<FittedModel> circuit;
  /// as identify() fits the effects that explain, in the direction that is controlled; none where
  /// there are none or that has no fit
  std::optional<FittedModel> extended;
  bool by_blocks = false;    ///< left-out blocks decided (selectByScore()), not the evidence
  bool is_lead_acid = true;  ///< the voltage is that of blocks of six lead-acid cells
  bool hasEffects() const { return !explanation.model.effects().empty(); }
};

/// A composition and where it stands, the current as its input.
struct Optimum {
  BatteryModel model = BatteryModel();
  CompositionPoint point;
};

/// What is missing in the base circuit, and the models with it.
struct ModelSelection {
  Explained explained;
  /// with the discrepancy of the voltage by currents and their memory, where it is used
  std::optional<Optimum> with_discrepancy;
};

/// @param found takes the verdict and all that speaks for it, the models that are handed on, and
/// notes on what was not weighed; extended equals base when nothing was added.
ModelSelection selectModel(const Recording& recording, const Residuals& residuals,
                           const DiagnoseOptions& options, Diagnosis& found);

/// @param driving a source that controls the voltage; none: the current is the input throughout.
/// @return the rows of the training part as they were sampled, each with what controls it.
InputSequence rowsOf(const Residuals& residuals, const std::optional<ChargerControl>& driving);

/// @return what the training part says for each mechanism with the current as its input: whether a
/// source is taken to control the voltage hangs on little.
MechanismEvidence weighMechanisms(const Residuals& residuals);

/// What the findings come to, the models that are handed on, and the effects that stand in the
/// extended one.
void judgeFindings(const Recording& recording, const Residuals& residuals,
                   const DiagnoseOptions& options, ModelSelection& selected, Diagnosis& found);

/// Opens the part that was held out: base and extended model on it, and what is handed on after it.
/// @param found takes them; what is withheld: Diagnosis::withheld_rmse.
void validate(const Recording& recording, const Residuals& residuals,
              const ModelSelection& selected, const DiagnoseOptions& options, Diagnosis& found);

}  // namespace battery_sof
