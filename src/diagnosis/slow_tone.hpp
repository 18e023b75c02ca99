#pragma once

#include <optional>

#include "diagnosis/whitened_fit.hpp"

namespace battery_sof {

/// A line in the spectrum of what a model leaves.
struct SlowTone {
  double period = 0.0;     ///< [s]
  double amplitude = 0.0;  ///< [V], by generalised least squares
  double power = 0.0;      ///< of its line over the spectrum around it [1]
};

/**
 * @brief Looks for a tone of one period in the innovation, which no current and no memory of it
 * explains (docs/physics.md#slow-tones).
 *
 *     P(f) = |DFT of the innovation, in bins of a second|^2,   power = max over f of P(f) ln 2 / median of P around f
 *
 * The noise model has taken up part of a tone as random walk; what it leaves is still a line.
 * Periods from two bins to a tenth of the recording. A bin is a second, or a sample where those are
 * farther apart. Not looked for where there are more than four bins a sample: most of such a
 * recording is gaps.
 *
 *     p(P > x) = prod over j = 0..m of (n - j) / (n - j + x / ln 2),   n = 2 m + 1 = 41 lines around f, the one in the middle the median
 *
 * @return the strongest line, if chance makes one like it in fewer than one recording of a thousand
 * and its amplitude is at least a quarter of the RMS error.
 */
std::optional<SlowTone> slowTone(const WhitenedFit& fit, const InputSequence& inputs);

}  // namespace battery_sof
