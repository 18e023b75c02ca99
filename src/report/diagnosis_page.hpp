#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

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

/// A trace over the samples of a series, by sample.
using Trace = std::function<double(std::size_t)>;

/**
 * @brief Picks samples of which a plot of several traces looks as one of all samples would.
 *
 * The time between first and last sample is cut into `buckets` equal parts; of each part its first
 * sample stays and, for every trace, its lowest and its highest one. Nothing is averaged: each
 * picked sample was measured, no extreme of any trace is lost, and all traces are drawn at the same
 * times.
 *
 * @param whole ranges of which every sample stays.
 * @return indices, increasing; every sample when there are at most 2 a bucket.
 */
std::vector<std::size_t> displaySamples(const Series& series, const std::vector<Trace>& traces,
                                        std::size_t buckets,
                                        const std::vector<IndexRange>& whole = {});

}  // namespace battery_sof
