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

/// Masks ranges; returns how many of their samples were not masked before.
std::size_t mask(std::vector<char>& masked, const std::vector<IndexRange>& ranges,
                 SampleFault fault) {
  std::size_t added = 0;
  for (const IndexRange& range : ranges)
    for (std::size_t k = range.first; k < range.last; ++k) {
      if (masked[k]) continue;
      masked[k] = static_cast<char>(fault);
      ++added;
    }
  return added;
}

/// Every sample at a limit of the channel that is proven in some of them.
std::vector<IndexRange> samplesAt(const std::vector<double>& limits, const Channel& channel) {
  std::vector<IndexRange> samples;
  for (const double limit : limits) {
    for (std::size_t k = 0; k < channel.values.size(); ++k) {
      if (channel.values[k] == limit) samples.push_back({k, k + 1});
    }
  }
  return samples;
}

}  // namespace

InstrumentLimits instrumentLimits(const Series& series) {
  InstrumentLimits limits;
  if (series.empty()) return limits;
  const Evidence evidence(series);
  limits.masked.assign(series.size(), 0);
  limits.current_limits = provenLimits(evidence, evidence.current);
  limits.voltage_limits = provenLimits(evidence, evidence.voltage);
  limits.clipped = mask(limits.masked, samplesAt(limits.current_limits, evidence.current),
                        SampleFault::kClipped) +
                   mask(limits.masked, samplesAt(limits.voltage_limits, evidence.voltage),
                        SampleFault::kClipped);
  for (const Channel* channel : {&evidence.current, &evidence.voltage})
    limits.stuck += mask(limits.masked, frozenRuns(evidence, *channel), SampleFault::kStuck);
  limits.repeated = mask(limits.masked, repeatedRuns(evidence), SampleFault::kRepeated);
  limits.voltage_lsb_std = evidence.voltage.step.value_or(0.0) / std::sqrt(12.0);
  const std::string causes = countsText(
      {{limits.clipped, "clipped"}, {limits.stuck, "stuck"}, {limits.repeated, "repeated"}});
  if (!causes.empty())
    limits.message = check_parts::counted(limits.maskedSamples(), "sample") + " of " +
                     std::to_string(series.size()) + " left out of the fit: " + causes + ".";
  return limits;
}

std::vector<char> InstrumentLimits::withoutClipped() const {
  std::vector<char> kept = masked;
  for (char& fault : kept)
    if (fault == static_cast<char>(SampleFault::kClipped)) fault = 0;
  return kept;
}

namespace {

constexpr double kSlowest = 0.2;      // [s] between samples; a crank shows as single samples
constexpr double kStride = 0.03;      // [s], in which the double layer hardly moves
constexpr double kStep = 10.0;        // [A], that shows r above noise
constexpr double kNear = 0.7;         // of the limit
constexpr double kRemembered = 30.0;  // [s]

/// Stretches in which the current reads a limit at which it is cut off.
std::vector<IndexRange> clippedStretches(const Series& series, const InstrumentLimits& limits) {
  return rangesWhere({0, series.size()}, [&](std::size_t k) {
    return contains(limits.current_limits, series.current[k]);
  });
}

/// From steps that reach most of the way to the limit: the flanks of what is cut off, in the same
/// direction, under as much current.
double resistanceNear(double limit, const Series& series, const InstrumentLimits& limits,
                      double interval) {
  const auto stride = static_cast<std::size_t>(std::max(1L, std::lround(kStride / interval)));
  double products = 0.0, squares = 0.0;
  for (std::size_t k = stride; k < series.size(); ++k) {
    const double by = series.current[k] - series.current[k - stride];
    const double reached = std::max(series.current[k] / limit, series.current[k - stride] / limit);
    if (std::abs(by) < kStep || reached < kNear || limits.masked[k] || limits.masked[k - stride])
      continue;
    products += by * (series.voltage[k] - series.voltage[k - stride]);
    squares += by * by;
  }
  return squares > 0.0 ? products / squares : 0.0;
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

Series withEstimatedCurrent(const Series& series, const InstrumentLimits& limits) {
  Series estimated = series;
  const double interval = medianInterval(series);
  if (limits.current_limits.empty() || !(interval > 0.0) || interval >= kSlowest) return estimated;
  for (const double limit : limits.current_limits) {
    const double resistance = resistanceNear(limit, series, limits, interval);
    if (!(resistance > 0.0)) continue;
    for (const IndexRange& stretch : clippedStretches(series, limits)) {
      const bool has_neighbours = stretch.first > 0 && stretch.last < series.size();
      if (series.current[stretch.first] == limit && has_neighbours)
        estimate(series, stretch, resistance, estimated);
    }
  }
  return estimated;
}

void maskBehindUnknownCharge(const Series& series, InstrumentLimits& limits) {
  for (const IndexRange& stretch : clippedStretches(series, limits)) {
    const bool is_unknown =
        std::any_of(series.voltage.begin() + static_cast<std::ptrdiff_t>(stretch.first),
                    series.voltage.begin() + static_cast<std::ptrdiff_t>(stretch.last),
                    [&](double voltage) { return contains(limits.voltage_limits, voltage); });
    if (!is_unknown) continue;
    const double until = series.time[stretch.last - 1] + kRemembered;
    std::size_t last = stretch.last;
    while (last < series.size() && series.time[last] <= until) ++last;
    limits.behind_clipped +=
        mask(limits.masked, {{stretch.last, last}}, SampleFault::kBehindClipped);
  }
}

}  // namespace battery_sof
