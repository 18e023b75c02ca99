#include "battery_sof/recording/source_overview.hpp"

#include <map>
#include <stdexcept>

namespace battery_sof {
namespace {

/// Where a stretch ends: at the first sample behind it, unless there is none or a gap lies between.
double endOf(const SourceStretch& stretch, const Series& series, double max_gap) {
  const std::size_t last = stretch.range.last;
  const bool goes_on = last < series.size() && series.time[last] - series.time[last - 1] <= max_gap;
  return series.time[goes_on ? last : last - 1];
}

}  // namespace

std::string describe(Imposed imposed) { return imposed == Imposed::kVoltage ? "voltage" : "current"; }

std::vector<ImposedTotals> totalsOf(const Source& source) {
  std::map<std::string, ImposedTotals> by_reason;
  for (const SourceStretch& stretch : source.stretches) {
    ImposedTotals& totals = by_reason[stretch.reason];
    totals.reason = stretch.reason;
    totals.imposed = stretch.imposed;
    ++totals.stretches;
    totals.samples += stretch.range.size();
  }
  std::vector<ImposedTotals> all;
  for (const auto& [reason, totals] : by_reason) all.push_back(totals);
  return all;
}

SourceOverview overviewOf(const Source& source, const Series& series) {
  if (source.imposes_voltage.size() != series.size())
    throw std::invalid_argument("overviewOf: source of " + std::to_string(source.imposes_voltage.size()) + " samples, series of " +
                                std::to_string(series.size()));
  SourceOverview overview{source.seen, source.share, source.summary, totalsOf(source), {}};
  std::vector<ImposedTime>& times = overview.voltage_imposed;
  for (const SourceStretch& stretch : source.stretches) {
    if (stretch.imposed != Imposed::kVoltage) continue;
    const double from = series.time[stretch.range.first], to = endOf(stretch, series, source.rule.max_gap);
    if (!times.empty() && times.back().to == from)
      times.back().to = to;
    else
      times.push_back({from, to});
  }
  return overview;
}

}  // namespace battery_sof
