#pragma once

#include "stage_explain.hpp"

namespace battery_sof {

/// The effects that explain, fitted under a noise model: for intervals and for the model that is
/// handed on.
struct FinalFit {
  /// Prepared::quiet, its samples weighed by the noise at edges (TimingJitterNoise)
  InputSequence quiet;
  bool at_edges = false;  ///< an effect shows at edges: fitted to Prepared::inputs
  /// the base circuit's where there is no effect, and where a source controls the voltage: effects
  /// are fitted in that direction then (nameEffects())
  WhitenedFit fit;
  const InputSequence& inputs(const Prepared& prepared) const {
    return at_edges ? prepared.inputs : quiet;
  }
};

FinalFit fitExplained(const Prepared& prepared, const Explained& explained);

}  // namespace battery_sof
