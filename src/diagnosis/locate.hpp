#pragma once

#include <optional>
#include <vector>

#include "diagnosis/diagnosis.hpp"
#include "diagnosis/regimes.hpp"
#include "diagnosis/whitened_fit.hpp"

namespace battery_sof {

/**
 * @brief Mean, slope and end value of the error in every regime with at least five episodes
 * (docs/physics.md#regimes).
 *
 * Value: mean over episodes of the error's mean, of its Theil-Sen slope (episodes of five samples
 * and a second), of its mean over their last fifth; with the 95 % interval of a mean of
 * neighbouring, hence dependent, episodes (Newey and West 1987).
 *
 * Test: neighbouring errors are dependent and a misfit of u_dc moves them all, so that their mean
 * would find a mismatch in noise. Tested is the score of the statistic's own signature s (one, time
 * since the episode's middle, or one in its last fifth; zero elsewhere) after whitening and
 * projection, with the variance of its own terms (White 1980):
 *
 *     x_n = (M K s)_n v_n,   p = erfc(|sum x_n| / sqrt(2 sum x_n^2))
 *
 * Innovations are independent, and what the parameters absorb is gone
 * (docs/physics.md#what-the-base-circuit-absorbs). A few episodes are enough, where they have many
 * samples.
 *
 * @return is_significant: among those that the step-up procedure of Benjamini and Hochberg (1995)
 * keeps at 0.02 over all statistics,
 *   and the interval excludes 0.
 */
std::vector<RegimeFinding> regimeFindings(const WhitenedFit& fit, const InputSequence& inputs,
                                          const std::vector<Regime>& regimes);

/**
 * @brief Stretches of time where innovations do not cancel (docs/physics.md#stretches-of-time;
 * MOSUM).
 *
 *     M = |sum f v| / sqrt(sum f^2)   over windows of 10, 30, 100, 300 s,   f = 1, sign(i), |i|
 *
 * Threshold: 99 % of the largest M of 200 simulated series of independent v of the same sampling,
 * over all windows and f.
 * |v| counts up to 5: no single sample makes a segment. Of windows above it the shortest are taken first, overlapping ones
 * left out, and those nearer to each other than the shorter of them is long are joined.
 *
 * @param noise of the model that explains the mismatch, once there is one: what the base model
 * misses has swollen its own
 *   noise model, which then shows only the worst of it. None: the fit's own.
 * @return in order of time; p_value: share of simulated series with a larger M. mean_error and
 * peak_error of the raw error.
 */
std::vector<MismatchSegment> mismatchSegments(
    const WhitenedFit& fit, const InputSequence& inputs, const std::vector<Regime>& regimes,
    const std::optional<NoiseModel>& noise = std::nullopt);

}  // namespace battery_sof
