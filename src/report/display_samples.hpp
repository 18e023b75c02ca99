#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

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
