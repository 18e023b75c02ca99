#include "battery_sof/naive/charge_phases.hpp"

#include <stdexcept>
#include <string>

namespace battery_sof {
namespace {

constexpr double kLeastImposed = 0.9;  // share of samples
constexpr double kFewestSamples = 3.0;

void requireMask(const Series& series, IndexRange range, const std::vector<char>& imposes_voltage) {
  if (imposes_voltage.size() == series.size() && range.first <= range.last && range.last <= series.size()) return;
  throw std::invalid_argument("charge phases: range " + std::to_string(range.first) + " to " + std::to_string(range.last) +
                              " and a mask of " + std::to_string(imposes_voltage.size()) + " for " + std::to_string(series.size()) +
                              " samples");
}

}  // namespace

std::vector<std::size_t> chargeBeginnings(const Series& series, IndexRange range, const std::vector<char>& imposes_voltage) {
  requireMask(series, range, imposes_voltage);
  std::vector<std::size_t> beginnings;
  bool discharged = false;
  for (std::size_t k = range.first; k < range.last; ++k) {
    if (series.current[k] < kDischargeCurrent) {
      discharged = true;
    } else if (discharged && imposes_voltage[k] && series.current[k] > 0.0) {
      beginnings.push_back(k);
      discharged = false;
    }
  }
  return beginnings;
}

std::optional<IndexRange> beginningOfCharge(const Series& series, IndexRange range, std::size_t first, double duration,
                                            const std::vector<char>& imposes_voltage) {
  requireMask(series, range, imposes_voltage);
  const double interval = medianInterval(series);
  if (first >= range.last || interval * kFewestSamples > duration) return std::nullopt;
  const double end = series.time[first] + duration - 0.5 * interval;
  std::size_t last = first, imposed = 0;
  for (; last < range.last && series.time[last] < end; ++last) imposed += imposes_voltage[last] ? 1 : 0;
  const bool complete = series.time[last - 1] + interval >= end;
  if (!complete || static_cast<double>(imposed) < kLeastImposed * duration / interval) return std::nullopt;
  return IndexRange{first, last};
}

}  // namespace battery_sof
