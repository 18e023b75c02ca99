#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// Why a sample is no measurement; zero is none.
enum class SampleFault : char { kClipped = 1, kStuck = 2, kRepeated = 3, kBehindClipped = 4 };

/// What a fit must know of the instrument: samples that are no measurement, and how finely the
/// others are known.
struct InstrumentLimits {
  /// One per sample of the series; a SampleFault for a sample that is no measurement, else 0. Its
  /// current is still the input of the simulation: nothing better is known.
  std::vector<char> masked;
  /// samples masked because a channel reads exactly its limit
  std::size_t clipped = 0;
  /// because a channel repeats one value while the other moves
  std::size_t stuck = 0;
  /// because both channels repeat the sample before
  std::size_t repeated = 0;
  /// because the charge before is unknown (maskBehindUnknownCharge)
  std::size_t behind_clipped = 0;
  /// [A], [V], at which the channels are cut off
  std::vector<double> current_limits, voltage_limits;
  /// [V], step / sqrt(12) when quantised, else 0: white noise
  double voltage_lsb_std = 0.0;
  double current_lsb_std = 0.0;  ///< [A], the same of the current
  /// one sentence with the counts; empty when nothing is masked
  std::string message;

  /// A sample is counted under its first reason, in the order of the members.
  std::size_t maskedSamples() const { return clipped + stuck + repeated + behind_clipped; }

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
 * moves up and down. A value that was entered (one exact value for minutes in a noisy channel) may
 * be right and is not masked.
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

}  // namespace battery_sof
