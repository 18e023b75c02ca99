#include "recording/deep_discharge.hpp"

#include <cmath>

#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kSmallCurrent = 25.0;  // [A], of the reserve capacity (EN 50342-1)
constexpr double kQuiet = 10.0;         // [s], a voltage that comes late is no deep discharge
constexpr double kLasting = 60.0;       // [s], a crank lasts a few

}  // namespace

bool DeepDischargeDetector::add(const Sample& sample, double max_gap) {
  if (run_ && sample.time - run_->last > max_gap) run_.reset();
  if (!(sample.voltage < kLimit)) {
    run_.reset();
    return false;
  }
  const bool is_quiet = std::abs(sample.current) <= kSmallCurrent;
  if (!run_) {
    run_ = Run{{sample.time, sample.time, sample.voltage, sample.current},
               sample.time,
               0.0,
               is_quiet,
               false};
    return false;
  }
  Run& run = *run_;
  if (run.is_quiet && is_quiet) run.quiet += sample.time - run.last;
  run.is_quiet = is_quiet;
  const double since = run.last;
  run.last = run.stretch.to = sample.time;
  if (sample.voltage < run.stretch.lowest) {
    run.stretch.lowest = sample.voltage;
    run.stretch.current = sample.current;
  }
  const bool was_deep = run.is_deep;
  if (run.quiet >= kQuiet || run.stretch.to - run.stretch.from >= kLasting) run.is_deep = true;
  if (run.is_deep) note(run, was_deep ? since : run.stretch.from);
  return run.is_deep && !was_deep;
}

void DeepDischargeDetector::note(Run& run, double since) {
  const bool is_new = since == run.stretch.from;
  if (is_new) ++count_;
  duration_ += run.stretch.to - since;
  if (count_ == 1) first_ = run.stretch;
  if (!deepest_ || run.stretch.lowest <= deepest_->lowest) deepest_ = run.stretch;
}

std::string DeepDischargeDetector::toString(double series_blocks) const {
  if (count_ == 0) return {};
  const std::string times = count_ == 1 ? format(" at %.0f s, for %.0f s", first_->from, duration_)
                                        : format(" %zu times, first at %.0f s, for %.0f s in all",
                                                 count_, first_->from, duration_);
  return format("the battery was discharged below %g V", series_blocks * kLimit) + times +
         format(", down to %.2f V at %.1f A", series_blocks * deepest_->lowest, deepest_->current);
}

DeepDischargeDetector findDeepDischarges(const Series& series) {
  DeepDischargeDetector detector;
  const double max_gap = gapThreshold(series);
  for (std::size_t k = 0; k < series.size(); ++k) detector.add(series[k], max_gap);
  return detector;
}

}  // namespace battery_sof
