#include "recording/fit_mask.hpp"

#include <algorithm>
#include <cmath>

#include "check_parts.hpp"
#include "recording/channel_statistics.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

using check_parts::Channel;
using check_parts::Evidence;

constexpr double kSlowest = 0.2;      // [s] between samples; a crank shows as single samples
constexpr double kStride = 0.03;      // [s], in which the double layer hardly moves
constexpr double kStep = 10.0;        // [A], that shows r above noise
constexpr double kNear = 0.7;         // of the limit
constexpr double kRemembered = 30.0;  // [s]

/// A sample keeps its first fault.
void mask(std::vector<char>& masked, const std::vector<IndexRange>& ranges, SampleFault fault) {
  for (const IndexRange& range : ranges)
    for (std::size_t k = range.first; k < range.last; ++k)
      if (!masked[k]) masked[k] = static_cast<char>(fault);
}

/// Stretches in which a channel reads a limit at which it is cut off.
std::vector<IndexRange> stretchesAt(const std::vector<double>& limits,
                                    const std::vector<double>& values) {
  return rangesWhere({0, values.size()},
                     [&](std::size_t k) { return contains(limits, values[k]); });
}

/// From steps that reach most of the way to the limit: the flanks of what is cut off, in the same
/// direction, under as much current.
double resistanceNear(double limit, const Series& series, const InstrumentLimits& limits,
                      double interval) {
  const auto stride = static_cast<std::size_t>(std::max(1L, std::lround(kStride / interval)));
  return changeSums(series, stride,
                    [&](std::size_t k, double di) {
                      const double reached =
                          std::max(series.current[k] / limit, series.current[k - stride] / limit);
                      return !(std::abs(di) < kStep || reached < kNear || limits.masked[k] ||
                               limits.masked[k - stride]);
                    })
      .slope();
}

void estimate(const Series& series, IndexRange stretch, double resistance, Series& estimated) {
  const std::size_t a = stretch.first - 1, b = stretch.last;
  const double limit = series.current[stretch.first];
  for (std::size_t k = stretch.first; k < stretch.last; ++k) {
    const double weight = (series.time[k] - series.time[a]) / (series.time[b] - series.time[a]);
    const double i_line = (1.0 - weight) * series.current[a] + weight * series.current[b];
    const double u_line = (1.0 - weight) * series.voltage[a] + weight * series.voltage[b];
    const double current = i_line + (series.voltage[k] - u_line) / resistance;
    estimated.current[k] = limit < 0.0 ? std::min(limit, current) : std::max(limit, current);
  }
}

}  // namespace

InstrumentLimits instrumentLimits(const Series& series) {
  InstrumentLimits limits;
  if (series.empty()) return limits;
  const Evidence evidence(series);
  limits.masked.assign(series.size(), 0);
  limits.current_limits = evidence.current.limits;
  limits.voltage_limits = evidence.voltage.limits;
  mask(limits.masked, stretchesAt(limits.current_limits, series.current), SampleFault::kClipped);
  mask(limits.masked, stretchesAt(limits.voltage_limits, series.voltage), SampleFault::kClipped);
  for (const Channel* channel : {&evidence.current, &evidence.voltage})
    mask(limits.masked, frozenRuns(evidence, *channel), SampleFault::kStuck);
  mask(limits.masked, repeatedRuns(evidence), SampleFault::kRepeated);
  limits.voltage_lsb_std = evidence.voltage.step.value_or(0.0) / std::sqrt(12.0);
  return limits;
}

std::vector<char> InstrumentLimits::withoutClipped() const {
  std::vector<char> kept = masked;
  for (char& fault : kept)
    if (fault == static_cast<char>(SampleFault::kClipped)) fault = 0;
  return kept;
}

Series withEstimatedCurrent(const Series& series, const InstrumentLimits& limits) {
  Series estimated = series;
  const double interval = medianInterval(series);
  if (limits.current_limits.empty() || !(interval > 0.0) || interval >= kSlowest) return estimated;
  for (const double limit : limits.current_limits) {
    const double resistance = resistanceNear(limit, series, limits, interval);
    if (!(resistance > 0.0)) continue;
    for (const IndexRange& stretch : stretchesAt(limits.current_limits, series.current)) {
      const bool has_neighbours = stretch.first > 0 && stretch.last < series.size();
      if (series.current[stretch.first] == limit && has_neighbours)
        estimate(series, stretch, resistance, estimated);
    }
  }
  return estimated;
}

void extendByKnownLimits(const Series& series, InstrumentLimits& limits) {
  const std::size_t known = limits.masked.size();
  limits.masked.resize(series.size(), 0);
  for (std::size_t k = known; k < series.size(); ++k)
    if (contains(limits.current_limits, series.current[k]) ||
        contains(limits.voltage_limits, series.voltage[k]))
      limits.masked[k] = static_cast<char>(SampleFault::kClipped);
}

void maskBehindUnknownCharge(const Series& series, InstrumentLimits& limits) {
  for (const IndexRange& stretch : stretchesAt(limits.current_limits, series.current)) {
    const auto is_cut_off = [&](std::size_t k) {
      return contains(limits.voltage_limits, series.voltage[k]);
    };
    if (rangesWhere(stretch, is_cut_off).empty()) continue;
    const double until = series.time[stretch.last - 1] + kRemembered;
    mask(limits.masked, {{stretch.last, firstAfter(series, until)}}, SampleFault::kBehindClipped);
  }
}

}  // namespace battery_sof
