#pragma once

#include <string>
#include <vector>

#include "battery_sof/intake.hpp"
#include "battery_sof/recording_error.hpp"

namespace battery_sof {

/**
 * @brief A recording from samples in memory, judged by Intake as those of a file are.
 * @param name for messages and reports, made printable().
 * @throws RecordingError when there is no sample, or as requireUsable() says.
 */
Recording recordingOf(const std::string& name, const std::vector<RawSample>& samples);

/// @return the samples of a series in order of time; a temperature measured at no sample's time is
/// one of its own, with NaN current and voltage.
std::vector<RawSample> rawSamplesOf(const Series& series);

/// @throws RecordingError when more than a tenth of the samples go back in time (they are not
/// sorted) or none is usable.
void requireUsable(const std::string& name, const Recording& recording);

}  // namespace battery_sof
