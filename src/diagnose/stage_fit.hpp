#pragma once

#include "stage_explain.hpp"

namespace battery_sof {

/// The effects that explain, fitted under a noise model: for intervals and for the model that is handed on.
struct FinalFit {
  Drive quiet;            ///< Prepared::quiet, its samples weighed by the noise at edges (EdgeNoise)
  bool at_edges = false;  ///< an effect shows at edges: fitted to Prepared::drive
  WhitenedFit fit;        ///< the base circuit's where there is no effect
  const Drive& drive(const Prepared& prepared) const { return at_edges ? prepared.drive : quiet; }
};

FinalFit fitExplained(const Prepared& prepared, const Explained& explained);

}  // namespace battery_sof
