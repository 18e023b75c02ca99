#pragma once

#include <vector>

#include "battery_sof/diagnose/whitened_fit.hpp"

namespace battery_sof {

constexpr int kHeldOutBlocks = 4;  ///< that a name is judged on

/// A model's errors on blocks that its fits did not see.
struct HeldOut {
  Eigen::VectorXd error;         ///< [V], measured minus modelled, one a sample of the drive; 0 where it is no measurement or in no block
  std::vector<double> deviance;  ///< one a block: -2 ln predictive density of its samples, one step ahead under the fit's noise
};

/**
 * @brief Errors of a fit on consecutive blocks, each left out of a refit of all parameters.
 *
 * The battery's state is carried through the block by the measured current; the noise stays the fit's, so only what the
 * physics learnt elsewhere counts. The drive's first minute is always fitted: without it the first state would be unknown.
 */
HeldOut heldOutErrors(const WhitenedFit& fit, const Drive& drive, int blocks, int threads);

/// What an addition gains on samples it did not see.
struct HeldOutGain {
  double deviance = 0.0;   ///< fall over all blocks
  int worse_blocks = 0;    ///< blocks whose deviance rises by more than chance
  double rms_share = 0.0;  ///< [1], fall of the RMS error relative to what it was: over all samples, or where the addition acts, whichever is larger
};

/// @param acts how much the addition changes the modelled voltage at each sample [V].
HeldOutGain gainOf(const HeldOut& before, const HeldOut& after, const Drive& drive, const Eigen::VectorXd& acts);

/// @return magnitude that an addition exceeds on the three tenths of the samples on which it acts most. @param acts not empty.
double leastActing(const Eigen::VectorXd& acts);

/// @return rms(adds) / rms(error), over all samples or where the addition acts, whichever is larger. @param adds, error [V], one a sample.
double addedRatio(const Eigen::VectorXd& adds, const Eigen::VectorXd& error, const Drive& drive);

/// @return the least such ratio of an addition that, independent of the error, makes up this share of the RMS of both. @param share [0, 1).
double leastAddedRatio(double share);

}  // namespace battery_sof
