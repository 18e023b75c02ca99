#pragma once

#include <Eigen/Core>

#include "diagnosis/whitened_fit.hpp"

namespace battery_sof {

/// Columns as the innovation sees them once the parameters had their share.
struct Signatures {
  Eigen::MatrixXd columns;  ///< (1 - Q Q') K s, samples x columns
  Eigen::MatrixXd biased;   ///< Q' K s, rank x columns
  Eigen::VectorXd length;   ///< |K s|

  /// Share of a column's length that the parameters leave [1]; 0 for an empty column.
  double freeShare(Eigen::Index column) const;
};

/// @param columns [V], samples x columns; taken in place.
Signatures signaturesOf(const WhitenedFit& fit, const InputSequence& inputs,
                        Eigen::MatrixXd columns);

/// @return max(1, mean of v^2) over what was measured: never below what the noise model says, and
/// not lessened by what a
///   test explains.
double innovationVariance(const WhitenedFit& fit);

}  // namespace battery_sof
