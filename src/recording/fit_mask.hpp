#pragma once

#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// Why a sample is no measurement; zero is none.
enum class SampleFault : char { kClipped = 1, kStuck = 2, kRepeated = 3, kBehindClipped = 4 };

/// What a fit must know of the instrument: samples that are no measurement, and how finely the
/// others are known.
struct InstrumentLimits {
  /// One per sample of the series; its first SampleFault where it is no measurement, else 0. Its
  /// current is still the input of the simulation: nothing better is known.
  std::vector<char> masked;
  /// [A], [V], at which the channels are cut off
  std::vector<double> current_limits, voltage_limits;
  /// [V], step / sqrt(12) when quantised, else 0: white noise
  double voltage_lsb_std = 0.0;

  /// masked, with clipped samples let in.
  std::vector<char> withoutClipped() const;
};

/**
 * @brief Samples that a fit must leave out, and the noise that quantisation adds
 * (docs/physics.md#quantisation, docs/physics.md#clipping, docs/physics.md#dropouts).
 *
 * - clipped: every sample at a limit that the clipping check proves. A current held by a source and
 *   a voltage held by a regulator are not clipped.
 * - stuck: the ranges in which the stuck check sees one channel repeat a value while the other
 *   moves up and down. A value that was entered (one exact value for minutes in a noisy channel)
 *   may be right and is not masked.
 * - repeated: both channels repeat the sample before, under load, where both flicker.
 *
 * The error of rounding is uniform over a step, so its standard deviation is step / sqrt(12); it is
 * white as long as the signal or its noise moves by more than a step from sample to sample.
 *
 * @param series any sampling; needs no temperature.
 * @return masked is empty for an empty series.
 * @note Behind a clipped or stuck current the simulated state is off by the charge that was not
 * seen, for as long as the battery remembers it; those samples are measured and not masked
 * (withEstimatedCurrent, maskBehindUnknownCharge).
 */
InstrumentLimits instrumentLimits(const Series& series);

/**
 * @brief What the current may have been where it is cut off, from what the voltage did.
 *
 *     i(t) = i_line(t) + (u(t) - u_line(t)) / r,   never nearer to zero than the limit
 *
 * i_line and u_line are straight from the last sample before to the first behind the clipped
 * stretch: what polarisation adds in it is taken for linear in time. r is the regression of the
 * changes of voltage on those of current over 30 ms that reach 70 % of the limit. On drives of the
 * reference simulator it finds 96 to 103 % of the charge that was cut off; a fast polarisation (0.2
 * s) of two fifths of the ohmic resistance, taken for current, makes it up to 28 % more; without it
 * a model driven by the current lacks that charge for as long as the battery remembers it.
 *
 * @return the series with that current; as it is for fewer than five samples a second, where r
 * cannot be estimated, and where the stretch has no neighbour on one side. Where the voltage is cut
 * off too the estimate is a lower bound.
 */
Series withEstimatedCurrent(const Series& series, const InstrumentLimits& limits);

/**
 * @brief Goes on with what earlier samples showed of the instrument: later ones that read a limit at
 * which those were cut off are masked. What only the later samples show is not looked for.
 * @param limits of the first samples of the series; it covers the whole series afterwards.
 */
void extendByKnownLimits(const Series& series, InstrumentLimits& limits);

/**
 * @brief Masks half a minute behind each stretch in which both channels are cut off: nothing
 * tells how much charge flowed, and the battery remembers it (docs/physics.md#base-circuit: 50 s
 * at rest, less under load).
 */
void maskBehindUnknownCharge(const Series& series, InstrumentLimits& limits);

}  // namespace battery_sof
