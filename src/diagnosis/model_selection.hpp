#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/explanation.hpp"
#include "diagnosis/residuals.hpp"
#include "diagnosis/score_selection.hpp"
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
  /// where left-out blocks decide: circuit and extended model as they were selected
  std::optional<ScoreSelection> selection;
  bool is_lead_acid = true;  ///< the voltage is that of blocks of six lead-acid cells
  bool hasEffects() const { return !explanation.model.effects().empty(); }
};

/// The effects that explain, fitted under a noise model: for intervals and for the model that is
/// handed on.
struct FinalFit {
  /// Residuals::quiet, its samples weighed by the noise at edges (TimingJitterNoise)
  InputSequence quiet;
  bool at_edges = false;  ///< an effect shows at edges: fitted to Residuals::inputs
  /// the base circuit's where there is no effect, and where a source controls the voltage: effects
  /// are fitted in that direction then (selectByScore())
  WhitenedFit fit;
  const InputSequence& inputs(const Residuals& residuals) const {
    return at_edges ? residuals.inputs : quiet;
  }
};

/// What is missing in the base circuit, and the models with it.
struct ModelSelection {
  Explained explained;
  FinalFit last;
  /// with the discrepancy of the voltage by currents and their memory, where it is used
  std::optional<WhitenedFit> with_discrepancy;
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
