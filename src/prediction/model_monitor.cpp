#include "prediction/model_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "estimation/fit_quality.hpp"
#include "prediction/pipeline.hpp"

namespace battery_sof {
namespace {

constexpr double kDenialLookInterval = 1.0;  // [s], whether a model is denied

}  // namespace

void ModelMonitor::install(const FittedModel& model, double max_gap) {
  watch_.reset();
  compared_.clear();
  is_denied_ = false;
  looked_at_ = -HUGE_VAL;
  tracker_.emplace(model, max_gap, steps_.residual_filter);
  if (!steps_.event_history) tracker_->intervals().event_history = {};
}

void ModelMonitor::learnFrom(const FittedModel& model, double max_gap) {
  install(model, max_gap);
  tracker_->learn();
}

void ModelMonitor::accept(const FittedModel& model, const IntervalCalibrations& calibrations) {
  compared_.clear();
  tracker_->setKnown(model);
  setCalibrations(calibrations);
}

void ModelMonitor::drop() {
  tracker_.reset();
  compared_.clear();
}

void ModelMonitor::lookBack(const Series& series) {
  tracker_->lookBack(series);
  watch_.beginBehind(tracker_->state().current);
}

void ModelMonitor::restartClock(const Sample& first, double moved, double max_gap) {
  if (!tracker_) return;
  FittedModel there = accepted();
  there.fit.window.from += moved;
  there.fit.window.to += moved;
  there.intervals.event_history.moveBy(moved);
  setStateFromVoltage(there, first.time, first.current, first.voltage);
  const IntervalCalibrations kept = calibrations();
  const bool learns = tracker_->learns();
  install(there, max_gap);
  if (learns) tracker_->learn();
  setCalibrations(kept);
}

IntervalCalibrations ModelMonitor::calibrations() const {
  return tracker_ ? tracker_->intervals().calibrations : IntervalCalibrations{};
}

void ModelMonitor::setCalibrations(const IntervalCalibrations& calibrations) {
  tracker_->intervals().calibrations = calibrations;
}

SessionEvents ModelMonitor::follow(const Sample& sample, double max_gap) {
  if (!tracker_ || sample.time <= tracker_->state().time) return {};
  SessionEvents events = compareEvents(sample, max_gap);
  const bool settled = tracker_->follow(sample.time, sample.current, sample.voltage);
  const auto& last = tracker_->last();
  if (settled && !last->voltage_controlled)
    compared_.push_back({last->time, last->measured, last->voltage});
  while (!compared_.empty() && compared_.front().time < sample.time - kBacktestSpan)
    compared_.pop_front();
  if (sample.time - looked_at_ >= kDenialLookInterval || !events.cranks.empty()) {
    is_denied_ = !denialOf(tracker_->modelNow()).empty();
    looked_at_ = sample.time;
  }
  return events;
}

SessionEvents ModelMonitor::compareEvents(const Sample& sample, double max_gap) {
  SessionEvents events;
  IntervalLearning& intervals = tracker_->intervals();
  const WatchedSample at = watch_.advance(sample, *tracker_, max_gap);
  const auto take = [&](EventComparison event, IntervalCalibration& calibration,
                        std::vector<EventComparison>& of_kind) {
    event.baseline = expectedBy(accepted().fit.baseline, event);
    of_kind.push_back(event);
    if (steps_.calibration) update(calibration, event.measured, event.expected);
    updateFrom(event);
  };
  if (const auto crank = watch_.cranks.add(at)) {
    intervals.missed_answer = watch_.cranks.missed();
    take(*crank, intervals.calibrations.cranks, events.cranks);
  }
  if (const auto charge = watch_.charges.add(at))
    take(*charge, intervals.calibrations.charges, events.charges);
  if (!accepted().fit.source) return events;
  if (const auto stop = watch_.stops.add(at)) {
    events.stops.push_back(*stop);
    if (stop->duration == PastEvent::kStopAge) updateFrom(*stop);
  }
  if (const auto charge = watch_.long_charges.add(at)) updateFrom(*charge);
  return events;
}

void ModelMonitor::updateFrom(const PastEvent& event) {
  if (accepted().fit.source && steps_.event_history) tracker_->updateFrom(event);
}

BacktestScore ModelMonitor::backtest() const {
  BacktestScore score;
  if (compared_.size() < 2) return score;
  std::vector<double> measured, expected;
  measured.reserve(compared_.size());
  expected.reserve(compared_.size());
  for (const Compared& instant : compared_) {
    measured.push_back(instant.measured);
    expected.push_back(instant.expected);
  }
  score.q_dyn_percent = qDyn(measured, expected);
  score.duration = compared_.back().time - compared_.front().time;
  return score;
}

}  // namespace battery_sof
