#pragma once

#include <string>

#include "battery_sof/series.hpp"
#include "diagnosis/diagnosis.hpp"

namespace battery_sof {

/// @return true when the plot library was installed where this program was built.
bool hasPlotLibrary();

/**
 * @brief A diagnosis as one HTML document that opens from disk: style, script, plot library and
 * data inside, no network.
 *
 * Plots hold the recording reduced by displaySamples(), so a page stays below 3 MB however long the
 * recording.
 *
 * @param recording the one that was diagnosed, at the same rate.
 * @param zoomable false, or no library: drawings in place of plots, and the page says why.
 * @throws std::invalid_argument when the modelled voltages are neither absent nor one a sample of
 * the recording.
 */
std::string diagnosisPage(const Recording& recording, const Diagnosis& diagnosis,
                          bool zoomable = hasPlotLibrary());

}  // namespace battery_sof
