#include "recording/fit_mask.hpp"

#include <cmath>

#include "channel_faults.hpp"

namespace battery_sof {
namespace {

using check_parts::Channel;
using check_parts::Evidence;

/// Masks the range; returns how many of its samples were not masked before.
std::size_t mask(std::vector<char>& masked, IndexRange range, SampleFault fault) {
  std::size_t added = 0;
  for (std::size_t k = range.first; k < range.last; ++k) {
    if (masked[k]) continue;
    masked[k] = static_cast<char>(fault);
    ++added;
  }
  return added;
}

std::size_t mask(std::vector<char>& masked, const std::vector<IndexRange>& ranges,
                 SampleFault fault) {
  std::size_t added = 0;
  for (const IndexRange& range : ranges) added += mask(masked, range, fault);
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

double roundingDeviation(const Channel& channel) {
  return channel.step.value_or(0.0) / std::sqrt(12.0);
}

std::string describeMasked(const InstrumentLimits& limits) {
  std::string causes;
  const auto add = [&causes](std::size_t count, const char* cause) {
    if (count > 0) causes += (causes.empty() ? "" : ", ") + std::to_string(count) + " " + cause;
  };
  add(limits.clipped, "clipped");
  add(limits.stuck, "stuck");
  add(limits.repeated, "repeated");
  if (causes.empty()) return "";
  return check_parts::counted(limits.maskedSamples(), "sample") + " of " +
         std::to_string(limits.masked.size()) + " left out of the fit: " + causes + ".";
}

}  // namespace

InstrumentLimits instrumentLimits(const Series& series) {
  InstrumentLimits limits;
  if (series.empty()) return limits;
  Recording recording;
  recording.series = series;
  const Evidence evidence(recording);
  limits.masked.assign(series.size(), 0);
  limits.current_limits = provenLimits(evidence, evidence.current);
  limits.voltage_limits = provenLimits(evidence, evidence.voltage);
  limits.clipped = mask(limits.masked, samplesAt(limits.current_limits, evidence.current),
                        SampleFault::kClipped) +
                   mask(limits.masked, samplesAt(limits.voltage_limits, evidence.voltage),
                        SampleFault::kClipped);
  for (const Channel* channel : {&evidence.current, &evidence.voltage}) {
    limits.stuck += mask(limits.masked, frozenRuns(evidence, *channel), SampleFault::kStuck);
  }
  limits.repeated = mask(limits.masked, repeatedRuns(evidence), SampleFault::kRepeated);
  limits.voltage_lsb_std = roundingDeviation(evidence.voltage);
  limits.current_lsb_std = roundingDeviation(evidence.current);
  limits.message = describeMasked(limits);
  return limits;
}

std::vector<char> InstrumentLimits::withoutClipped() const {
  std::vector<char> kept = masked;
  for (char& fault : kept)
    if (fault == static_cast<char>(SampleFault::kClipped)) fault = 0;
  return kept;
}

}  // namespace battery_sof
