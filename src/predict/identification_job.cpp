#include "battery_sof/predict/identification_job.hpp"

#include <cmath>

#include "battery_sof/identify/error_tracker.hpp"
#include "battery_sof/identify/window.hpp"
#include "battery_sof/predict/state_tracker.hpp"
#include "battery_sof/recording/fit_mask.hpp"

namespace battery_sof {

namespace {

double lengthOf(const IdentificationJob& job) {
  return job.window_length.value_or(defaultWindowLength(job.series));
}

double openLoopRmse(FittedModel model, const Series& series, IndexRange range, double max_gap) {
  const std::size_t first = range.first;
  setStateFromVoltage(model, series.time[first], series.current[first], series.voltage[first]);
  StateTracker tracker(model, max_gap);
  double sum = 0.0;
  for (std::size_t n = first + 1; n < range.last; ++n) {
    tracker.advance(series.time[n], series.current[n]);
    sum += std::pow(tracker.expectedVoltage() - series.voltage[n], 2);
  }
  return std::sqrt(sum / static_cast<double>(range.size()));
}

void compareOnRecentWindow(IdentificationResult& result, const IdentificationJob& job) {
  const IndexRange recent = recentWindow(job.series, lengthOf(job));
  result.recent_rmse = openLoopRmse(*result.model, job.series, recent, result.max_gap);
  if (job.incumbent) {
    result.incumbent_rmse = openLoopRmse(*job.incumbent, job.series, recent, result.max_gap);
  }
}

}  // namespace

IndexRange recentWindow(const Series& series, double length) {
  if (series.empty()) return {};
  IndexRange recent = contiguousRanges(series, gapThreshold(series)).back();
  const double from = series.time.back() - length;
  while (series.time[recent.first] < from) ++recent.first;
  return recent;
}

IdentificationResult runIdentification(const IdentificationJob& job) {
  IdentificationResult result;
  result.epoch = job.epoch;
  result.max_gap = gapThreshold(job.series);
  WindowSearch search;
  search.length = job.window_length;
  const WindowChoice choice = chooseWindow(job.series, search);
  result.message = choice.message;
  if (!choice.range) return result;
  if (choice.excitation < job.min_suitability) {
    result.message = "the best window's suitability of " + std::to_string(choice.excitation) +
                     " is below the required " + std::to_string(job.min_suitability);
    return result;
  }
  IdentifyOptions options = job.options;
  const InstrumentLimits limits = instrumentLimits(job.series);
  options.masked = limits.withoutClipped();
  options.voltage_lsb_std = limits.voltage_lsb_std;
  result.model = identify(job.series, *choice.range, options);
  result.message = result.model->message;
  if (!isUsable(*result.model)) return result;
  fitErrors(*result.model, job.series, *choice.range);
  carryState(*result.model, job.series, job.series.size() - 1);
  compareOnRecentWindow(result, job);
  return result;
}

}  // namespace battery_sof
