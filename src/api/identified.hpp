#pragma once

#include <string>

#include "battery_sof/series.hpp"
#include "diagnosis/diagnosis.hpp"
#include "estimation/identification.hpp"

namespace battery_sof {

/// Why there is nothing left to work with at the design rate.
inline constexpr char kTooShortForDesignRate[] =
    "the recording is too short: brought down to 100 Hz nothing is left of it, at least 0.1 s are "
    "needed";

/// @return planFit() and fitPlanned(), with the time they took; a usable model stands at the end of
/// the series and holds what a later recording is compared with.
FittedModel identified(const Series& series, const FitRequest& request);

/// Notes where a model comes from. @param hash of the file, empty when there is none.
void nameOrigin(FittedModel& model, const Recording& recording, const std::string& hash,
                double series_blocks);

/// The same of both models of a diagnosis; several blocks in series are said with the instrument.
void nameOrigin(Diagnosis& diagnosis, const Recording& recording, const std::string& hash,
                double series_blocks);

}  // namespace battery_sof
