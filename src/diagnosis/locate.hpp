#pragma once

#include <functional>
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
 * @brief Stretches of time in which the error of the base circuit is larger than it usually is
 * (docs/physics.md#stretches-of-time).
 *
 * The circuit is fitted to all rows by the robust cost of errors in both variables (ChannelErrors),
 * which a stretch of some minutes hardly moves. Of every minute, or every 30 rows, the level
 *
 *     L = sqrt(mean rho(e / sigma)),   p = m P(F(1, m - 1) > (L / median of L)^2),   m minutes
 *
 * counts a minute as one independent error. Minutes with p up to 0.02 make stretches, which begin and
 * end with ten seconds whose own level is twice the median; a gap of a minute ends one.
 *
 * @param inputs each row with what controls it.  @param start of the circuit's search.
 * @param regimes of the rows.  @param least [V], RMS error of a stretch that is reported.
 * @param pulse called before every pass over the rows; may be empty.
 * @return in order of time; p_value of its clearest minute. Where the voltage is the input the
 * current's error counts as a voltage's through kOhmsOfCurrentError.
 */
std::vector<MismatchSegment> mismatchSegments(const InputSequence& inputs,
                                              const CompositionPoint& start,
                                              const std::vector<Regime>& regimes, double least,
                                              const std::function<void()>& pulse = nullptr);

}  // namespace battery_sof
