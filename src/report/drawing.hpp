#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
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

/// An axis from the lowest to the highest value that is included.
struct Scale {
  double low = HUGE_VAL, high = -HUGE_VAL;
  void include(double value);
  double share(double value) const;  ///< [0, 1]; in the middle where all values are one
};

inline constexpr double kDrawingWidth = 1000.0, kDrawingHeight = 245.0;  ///< of a view box

/// @return an SVG path of a trace, broken where the recording has a gap. @param name its class.
std::string tracePath(const Series& series, const std::vector<std::size_t>& shown,
                      const Trace& trace, const std::string& name, const Scale& time,
                      const Scale& value);

/// @return a figure of paths in a view box of the size above, below its title and what it spans.
/// @param span, legend HTML.
std::string drawingFigure(const std::string& title, const std::string& span,
                          const std::string& legend, const std::string& paths);

}  // namespace battery_sof
