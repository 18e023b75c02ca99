#pragma once

#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// @return median of the sampling intervals between the samples of a range alone [s]; 0 for fewer
/// than two samples.
double medianInterval(const std::vector<double>& time, IndexRange range);

/// @return gapThreshold() of a series whose median interval is known. @param median_interval [s].
double gapThreshold(double median_interval);

}  // namespace battery_sof
