#include "recording/crank_current.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "recording/channel_statistics.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kSmallestPulse = 60.0;       // [A]; less is drawn by consumers of a vehicle
constexpr double kOrdinaryShare = 0.9;        // of the samples
constexpr double kClearOfLoad = 2.0;          // times the ordinary load
constexpr double kStarterDrop = 1.0;          // [V] of a block
constexpr double kTurningShare = 0.6;         // of the first rush, while the starter turns
constexpr std::size_t kRepeated = 3;          // pulses
constexpr std::size_t kSamplesAroundDip = 2;  // a voltage a sample late still shows it

/// [A], magnitude of what nine samples in ten stay below.
double ordinaryLoad(const Series& series) {
  std::vector<double> discharge;
  for (const double current : series.current) discharge.push_back(std::max(0.0, -current));
  return quantile(std::move(discharge), kOrdinaryShare);
}

/// [V], from just before a pulse to its lowest.
double dropOf(const Series& series, IndexRange pulse) {
  const auto voltage = series.voltage.begin();
  const auto at = [&](std::size_t n) { return voltage + static_cast<std::ptrdiff_t>(n); };
  const std::size_t before = pulse.first - std::min(pulse.first, kSamplesAroundDip);
  const std::size_t end = std::min(series.size(), pulse.last + kSamplesAroundDip);
  const double highest = *std::max_element(at(before), at(std::max(pulse.first, before + 1)));
  return highest - *std::min_element(at(pulse.first), at(end));
}

}  // namespace

std::string toString(CrankCurrent::Source source) {
  constexpr std::array kNames = {"given", "recording", "usual"};
  return kNames.at(static_cast<std::size_t>(source));
}

CrankCurrent findCrankCurrent(const Series& series) {
  CrankCurrent found;
  if (series.empty() || medianInterval(series) > EventLimits::kCrankMaxDuration) return found;
  const double least = std::max(kSmallestPulse, kClearOfLoad * ordinaryLoad(series));
  if (least >= -kCrankCurrent) return found;
  std::vector<double> depths;
  for (const Event& pulse : detectCranks(series, {0, series.size()}, EventLimits{-least}))
    if (dropOf(series, pulse.range) >= kStarterDrop) depths.push_back(-pulse.peak_current);
  if (depths.empty()) return found;
  std::sort(depths.begin(), depths.end(), std::greater<>());
  const double depth = depths[std::min(depths.size(), kRepeated) - 1];
  found.pulse = -depth;
  const auto usual =
      std::count_if(depths.begin(), depths.end(), [](double one) { return one >= -kCrankCurrent; });
  if (2 * static_cast<std::size_t>(usual) >= depths.size()) return found;
  found.current = -std::clamp(std::round(kTurningShare * depth), least, -kCrankCurrent);
  found.source = CrankCurrent::Source::kRecording;
  return found;
}

CrankCurrent crankCurrentOf(const Series& series, std::optional<double> given) {
  if (!given) return findCrankCurrent(series);
  requireThat(*given < 0.0, "crank_current [A]", *given, "below 0");
  return {*given, CrankCurrent::Source::kGiven};
}

}  // namespace battery_sof
