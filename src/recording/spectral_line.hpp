#pragma once

#include <cstddef>
#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// A tone in evenly sampled values.
struct SpectralLine {
  double frequency = 0.0;   ///< [cycles per sample], 0 to 0.5
  double amplitude = 0.0;   ///< in the unit of the values; median over the blocks
  double share = 0.0;       ///< of the blocks in which the line stands out
  double steadiness = 0.0;  ///< of the phase advance from block to block; 1 for a pure tone
};

/// What was looked at, and the lines in it.
struct LineSearch {
  std::size_t blocks = 0;
  std::vector<SpectralLine> lines;  ///< the greatest amplitude first
};

constexpr std::size_t kLineBlock = 256;    ///< samples in a block
constexpr std::size_t kLineBlocksMin = 8;  ///< with fewer no line is looked for

/**
 * @brief Narrow lines of steady phase, by short periodograms (Welch, blocks of 256 samples, linear
 * trend taken off, Hann window, no overlap).
 *
 * In noise that is white, or coloured smoothly over some 30 bins, a bin P of the periodogram is
 * exponentially distributed (chi-square of two degrees of freedom), so that its median is ln 2 of
 * its mean and
 *
 *     Pr{ P > median / ln 2 * ln(K / alpha) } = alpha / K
 *
 * with the median of the neighbouring bins, K bins in a block and alpha = 0.01, the probability of
 * a false positive anywhere in one block. A line exceeds that in four of five blocks or more; in
 * noise eight blocks do so with a probability below 1e-20. Its phase advances alike from block to
 * block: the mean of exp(i advance) has a magnitude of 0.8 or more, which excludes resonances and
 * loads that switch at irregular times.
 *
 * A tone must have about 0.6 standard deviations of white noise to be found. Bins below 8 and above
 * 120 (of 128) are not looked at: trends leak into the former, the mirror image into the latter.
 *
 * @param values  any unit.   @param ranges evenly sampled parts of values, in order.
 * @return no line when there are fewer than eight blocks. The frequency is known to a bin (1/256),
 * and far better where the line is not half-way between two.
 */
LineSearch findSpectralLines(const std::vector<double>& values,
                             const std::vector<IndexRange>& ranges);

/**
 * @brief Amplitude of the values at one frequency, from the same blocks.
 * @param frequency [cycles per sample], 0 to 0.5.
 * @return median over the blocks, with what noise and trends have there; 0 without a block.
 */
double amplitudeAt(const std::vector<double>& values, const std::vector<IndexRange>& ranges,
                   double frequency);

}  // namespace battery_sof
