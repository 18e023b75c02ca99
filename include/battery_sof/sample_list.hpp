#pragma once

#include <string>
#include <vector>

#include "battery_sof/intake.hpp"
#include "battery_sof/recording_error.hpp"

namespace battery_sof {

/**
 * @brief Makes a recording of samples in memory, validated by Intake like those of a file.
 * @param name for messages and reports, made printable().
 * @throws RecordingError if there is no sample, or as requireUsable() does.
 */
Recording recordingOf(const std::string& name, const std::vector<RawSample>& samples);

/// @return the samples of a series in order of time. A temperature that was measured at the time of
/// no sample becomes a sample of its own, with NaN current and voltage.
std::vector<RawSample> rawSamplesOf(const Series& series);

/// @throws RecordingError if more than a tenth of the samples go back in time, because they are
/// then not sorted, or if none is usable.
void requireUsable(const std::string& name, const Recording& recording);

}  // namespace battery_sof
