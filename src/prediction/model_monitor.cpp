#include "prediction/model_monitor.hpp"

#include "estimation/fit_quality.hpp"
#include "prediction/pipeline.hpp"

namespace battery_sof {

void ModelMonitor::install(const FittedModel& model, double max_gap) {
  model_ = model;
  fitted_until_ = model.fit.window.to;
  compared_.clear();
  if (!steps_.event_history) model_->intervals.event_history = {};
  tracker_.emplace(*model_, max_gap, steps_.residual_filter);
  tracker_->setCalibrations(crank_calibration_, charge_calibration_);
}

void ModelMonitor::learnFrom(const FittedModel& model, double max_gap) {
  install(model, max_gap);
  tracker_->learn();
}

void ModelMonitor::goOnAs(const ModelMonitor& other, const FittedModel& model) {
  model_ = model;
  fitted_until_ = model.fit.window.to;
  compared_.clear();
  tracker_ = other.tracker_;
  tracker_->setKnown(model);
  tracker_->setCalibrations(crank_calibration_, charge_calibration_);
  watch_ = other.watch_;
}

void ModelMonitor::lookBack(const Series& series) {
  tracker_->lookBack(series);
  watch_.beginBehind(tracker_->state().current);
}

void ModelMonitor::forgetPast() {
  watch_.reset();
  compared_.clear();
}

void ModelMonitor::moveTo(const StreamSample& first, double moved, double max_gap) {
  forgetPast();
  if (!model_) return;
  fitted_until_ += moved;
  FittedModel there = *model_;
  there.intervals.event_history = tracker_->eventHistory();
  there.intervals.event_history.moveBy(moved);
  setStateFromVoltage(there, first.time, first.current, first.voltage);
  const bool learns = tracker_->learns();
  tracker_.emplace(there, max_gap, steps_.residual_filter);
  if (learns) tracker_->learn();
  tracker_->setCalibrations(crank_calibration_, charge_calibration_);
}

void ModelMonitor::setCalibrations(const IntervalCalibration& crank,
                                   const IntervalCalibration& charge) {
  crank_calibration_ = crank;
  charge_calibration_ = charge;
  if (tracker_) tracker_->setCalibrations(crank, charge);
}

SessionEvents ModelMonitor::follow(const StreamSample& sample, double max_gap) {
  if (!tracker_ || sample.time <= tracker_->state().time) return {};
  SessionEvents events = watch(sample, max_gap);
  tracker_->setCalibrations(crank_calibration_, charge_calibration_);
  const bool settled = tracker_->follow(sample.time, sample.current, sample.voltage);
  if (settled && !tracker_->last().voltage_controlled)
    compared_.push_back({tracker_->lastTime(), tracker_->lastVoltage(), tracker_->last().voltage});
  while (!compared_.empty() && compared_.front().time < sample.time - kBacktestSpan)
    compared_.pop_front();
  return events;
}

SessionEvents ModelMonitor::watch(const StreamSample& sample, double max_gap) {
  SessionEvents events;
  const WatchedSample at = watch_.moveTo(sample, *tracker_, max_gap);
  if (auto crank = watch_.cranks.add(at)) {
    crank->baseline = baselineCrankMinimum(model_->fit.baseline, crank->current);
    events.cranks.push_back(*crank);
    if (steps_.calibration) update(crank_calibration_, crank->measured, crank->expected);
    updateFrom(*crank);
  }
  if (auto charge = watch_.charges.add(at)) {
    charge->baseline =
        baselineChargeCurrent(model_->fit.baseline, charge->voltage, charge->duration);
    events.charges.push_back(*charge);
    if (steps_.calibration) update(charge_calibration_, charge->measured, charge->expected);
    charge_voltages_.push_back(charge->voltage);
    if (charge_voltages_.size() > kChargesKept) charge_voltages_.pop_front();
    updateFrom(*charge);
  }
  if (!model_->fit.source) return events;
  if (const auto stop = watch_.stops.add(at)) {
    events.stops.push_back(*stop);
    if (stop->duration == PastEvent::kStopAge) updateFrom(*stop);
  }
  if (const auto charge = watch_.long_charges.add(at)) updateFrom(*charge);
  return events;
}

void ModelMonitor::updateFrom(const PastEvent& event) {
  if (model_->fit.source && steps_.event_history) tracker_->updateFrom(event);
}

std::optional<double> ModelMonitor::chargeVoltage() const {
  if (tracker_)
    if (const auto known = usualVoltage(tracker_->eventHistory().charges)) return known;
  if (charge_voltages_.empty()) return std::nullopt;
  return medianOf({charge_voltages_.begin(), charge_voltages_.end()});
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
