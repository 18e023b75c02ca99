#pragma once

#include <algorithm>
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
  bool is_lead_acid = true;        ///< the voltage is that of blocks of six lead-acid cells
  std::vector<std::string> notes;  ///< on what was not weighed, a sentence each
  bool hasEffects() const { return !explanation.model.effects().empty(); }
};

/// The effects that explain, fitted under a noise model: for intervals and for the model that is
/// handed on.
struct FinalFit {
  /// Residuals::quiet, its samples weighed by the noise at edges (TimingJitterNoise)
  InputSequence quiet;
  bool at_edges = false;  ///< an effect shows at edges: fitted to Residuals::inputs
  /// the base circuit's where there is no effect, and where a source controls the voltage: effects
  /// are fitted in that direction then (nameEffects())
  WhitenedFit fit;
  const InputSequence& inputs(const Residuals& residuals) const {
    return at_edges ? residuals.inputs : quiet;
  }
};

/// The discrepancy of the voltage by currents and their memory, checked on blocks left out.
struct EstimatedDiscrepancy {
  UnexplainedPart unexplained;
  std::optional<DiscrepancyFinding> finding;    ///< none where it is neither used nor needed
  std::optional<WhitenedFit> with_discrepancy;  ///< where it is used: the model with it
  bool isUsed() const { return finding && finding->is_used; }
  /// Whether it takes enough of the error on left-out blocks to be reported; a little less error is
  /// worth a place in the model alone. A block that the others hardly determine is missed by more
  /// than what is missing: the circuit fitted to all of them must be missed by more, too.
  bool holds() const {
    if (!isUsed()) return false;
    const LeftOutErrors& errors = finding->left_out;
    return errors.discrepancy <
           std::min((1.0 - kCatalogueTolerance) * errors.base, errors.in_sample);
  }
};

/// What the findings come to.
struct Judged {
  Verdict verdict = Verdict::kInsufficientData;
  std::vector<SelectedTerm> terms;  ///< of the explanation
  std::optional<Mechanism> mechanism;
  double probability = 0.0;                      ///< of it [0, 1]
  std::vector<MechanismProbability> mechanisms;  ///< Diagnosis::mechanisms
  std::vector<MechanismEvidence> evidence;       ///< with what was accepted
  std::vector<Candidate> candidates;             ///< best first
  std::vector<DetectionLimit> detection_limits;
};

/// The models that are handed on, and the effects that stand in the extended one.
struct Named {
  FittedModel base, extended;  ///< extended equals base when nothing was added
  /// the base model in the direction that is controlled, where a source controls the voltage
  std::optional<FittedModel> base_both_ways;
  std::vector<NamedEffect> effects;
};

/// What is missing in the base circuit, and the models with and without it.
struct ModelSelection {
  Explained explained;
  FinalFit last;
  EstimatedDiscrepancy discrepancy;
  Judged judged;
  Named named;
};

ModelSelection selectModel(const Recording& recording, const Residuals& residuals,
                           const DiagnoseOptions& options);

/// @return what the training part says for each mechanism with the current as its input: whether a
/// source is taken to control the voltage hangs on little.
MechanismEvidence weighMechanisms(const Residuals& residuals, const DiagnoseOptions& options);

Judged judgeFindings(const Recording& recording, const Residuals& residuals,
                     const Explained& explained, const FinalFit& last,
                     const EstimatedDiscrepancy& discrepancy, const DiagnoseOptions& options);

Named nameEffects(const Recording& recording, const Residuals& residuals,
                  const Explained& explained, const FinalFit& last,
                  const EstimatedDiscrepancy& discrepancy, const Judged& judged);

}  // namespace battery_sof
