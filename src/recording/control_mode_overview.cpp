#include "recording/control_mode_overview.hpp"

#include <map>
#include <stdexcept>

namespace battery_sof {
namespace {

/// Where a stretch ends: at the first sample behind it, unless there is none or a gap lies between.
double endOf(const ControlModeStretch& stretch, const Series& series, double max_gap) {
  const std::size_t last = stretch.range.last;
  const bool goes_on = last < series.size() && series.time[last] - series.time[last - 1] <= max_gap;
  return series.time[goes_on ? last : last - 1];
}

}  // namespace

std::string toString(ControlMode controlled) {
  return controlled == ControlMode::kVoltage ? "voltage" : "current";
}

std::vector<ControlModeTotals> totalsOf(const ControlModes& source) {
  std::map<std::string, ControlModeTotals> by_reason;
  for (const ControlModeStretch& stretch : source.stretches) {
    ControlModeTotals& totals = by_reason[stretch.reason];
    totals.reason = stretch.reason;
    totals.mode = stretch.mode;
    ++totals.stretches;
    totals.samples += stretch.range.size();
  }
  std::vector<ControlModeTotals> all;
  for (const auto& [reason, totals] : by_reason) all.push_back(totals);
  return all;
}

ControlModeOverview overviewOf(const ControlModes& source, const Series& series) {
  if (source.voltage_controlled.size() != series.size())
    throw std::invalid_argument("overviewOf: source of " +
                                std::to_string(source.voltage_controlled.size()) +
                                " samples, series of " + std::to_string(series.size()));
  ControlModeOverview overview{source.seen, source.share, source.summary, totalsOf(source), {}};
  std::vector<ControlledTime>& times = overview.voltage_controlled;
  for (const ControlModeStretch& stretch : source.stretches) {
    if (stretch.mode != ControlMode::kVoltage) continue;
    const double from = series.time[stretch.range.first],
                 to = endOf(stretch, series, source.rule.max_gap);
    if (!times.empty() && times.back().to == from)
      times.back().to = to;
    else
      times.push_back({from, to});
  }
  return overview;
}

}  // namespace battery_sof
