#include <cstdio>

#include "diagnosis/change.hpp"
#include "experiment.hpp"
#include "recording/resample.hpp"

namespace battery_sof {
namespace {

/// Stretches of so much driving [s]; nothing is driven in a gap.
std::vector<Series> drivesOf(const Series& series, double length) {
  const double max_gap = gapThreshold(series);
  std::vector<Series> drives;
  double driven = 0.0;
  std::size_t first = 0;
  for (std::size_t n = 1; n < series.size(); ++n) {
    const double step = series.time[n] - series.time[n - 1];
    driven += step <= max_gap ? step : 0.0;
    if (driven < length && n + 1 < series.size()) continue;
    drives.push_back(slice(series, {first, n + 1}));
    first = n + 1;
    driven = 0.0;
  }
  return drives;
}

Series changed(Series series, const ChangeOfDrives& change) {
  for (std::size_t n = 0; n < series.size(); ++n) {
    series.voltage[n] += change.contact * series.current[n];
    series.current[n] += change.offset;
  }
  return series;
}

void followFrom(std::size_t first, const std::vector<Series>& drives, const std::string& name,
                const ChangeOfDrives& change) {
  std::shared_ptr<const ResponseTable> reference;
  int since = 0;
  for (std::size_t k = first; k < drives.size(); ++k) {
    const bool is_changed = since >= change.after;
    const auto next =
        !reference && change.one_drive
            ? responseTable(drives[k])
            : withDrive(reference, is_changed ? changed(drives[k], change) : drives[k]);
    if (!next) continue;
    reference = next;
    if (!reference->since) continue;
    ++since;
    const ChangeDiagnosis found = diagnoseChange(reference);
    std::printf("%s,%zu,%d,%d,%s,%s\n", name.c_str(), first, since, is_changed,
                toString(found.verdict).c_str(),
                found.changes.empty() ? "" : found.changes.front().id.c_str());
  }
}

}  // namespace

void compareDrives(const Recording& recording, const ExperimentOptions& o) {
  const auto drives = drivesOf(atDesignRate(recording.series), o.change.drive);
  for (std::size_t first = 0; first < o.change.references && first < drives.size(); ++first)
    followFrom(first, drives, recording.name, o.change);
}

}  // namespace battery_sof
