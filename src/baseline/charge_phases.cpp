#include "baseline/charge_phases.hpp"

#include <stdexcept>
#include <string>

namespace battery_sof {
namespace {

constexpr double kMinControlled = 0.9;  // share of samples
constexpr double kFewestSamples = 3.0;

void requireMask(const Series& series, IndexRange range,
                 const std::vector<char>& voltage_controlled) {
  if (voltage_controlled.size() == series.size() && range.first <= range.last &&
      range.last <= series.size())
    return;
  throw std::invalid_argument("charge phases: range " + std::to_string(range.first) + " to " +
                              std::to_string(range.last) + " and a mask of " +
                              std::to_string(voltage_controlled.size()) + " for " +
                              std::to_string(series.size()) + " samples");
}

}  // namespace

std::vector<std::size_t> chargeBeginnings(const Series& series, IndexRange range,
                                          const std::vector<char>& voltage_controlled) {
  requireMask(series, range, voltage_controlled);
  std::vector<std::size_t> beginnings;
  EventDetector detector;
  for (std::size_t k = range.first; k < range.last; ++k) {
    detector.add(series.time[k], series.current[k], false, 0.0);
    if (!voltage_controlled[k])
      detector.denyCharge();
    else if (detector.chargeBegins())
      beginnings.push_back(k);
  }
  return beginnings;
}

std::optional<IndexRange> beginningOfCharge(const Series& series, IndexRange range,
                                            std::size_t first, double duration,
                                            const std::vector<char>& voltage_controlled) {
  requireMask(series, range, voltage_controlled);
  const double interval = medianInterval(series);
  if (first >= range.last || interval * kFewestSamples > duration) return std::nullopt;
  const double end = series.time[first] + duration - 0.5 * interval;
  std::size_t last = first, controlled = 0;
  for (; last < range.last && series.time[last] < end; ++last)
    controlled += voltage_controlled[last] ? 1 : 0;
  const bool complete = series.time[last - 1] + interval >= end;
  if (!complete || static_cast<double>(controlled) < kMinControlled * duration / interval)
    return std::nullopt;
  return IndexRange{first, last};
}

}  // namespace battery_sof
