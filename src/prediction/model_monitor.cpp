#include "prediction/model_monitor.hpp"

#include "estimation/fit_quality.hpp"
#include "prediction/event_corrections.hpp"

namespace battery_sof {

ModelMonitor::ModelMonitor(const EventLimits& limits) : crank_watch_(limits) {}

void ModelMonitor::install(const FittedModel& model, double max_gap) {
  model_ = model;
  fitted_until_ = model.fit.window.to;
  compared_.clear();
  tracker_.emplace(model, max_gap);
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
  crank_watch_ = other.crank_watch_;
  charge_watch_ = other.charge_watch_;
  long_charge_watch_ = other.long_charge_watch_;
  stop_watch_ = other.stop_watch_;
}

void ModelMonitor::lookBack(const Series& series) {
  tracker_->lookBack(series);
  charge_watch_.beginBehind(tracker_->state().current);
  long_charge_watch_.beginBehind(tracker_->state().current);
  stop_watch_.beginBehind();
  crank_watch_.reset();
}

void ModelMonitor::forgetPast() {
  crank_watch_.reset();
  stop_watch_.reset();
  charge_watch_.reset();
  long_charge_watch_.reset();
  compared_.clear();
}

void ModelMonitor::moveTo(const StreamSample& first, double moved, double max_gap) {
  forgetPast();
  crank_selector_.moveBy(moved);
  charge_selector_.moveBy(moved);
  long_charge_selector_.moveBy(moved);
  if (!model_) return;
  fitted_until_ += moved;
  FittedModel there = *model_;
  there.intervals.event_history = tracker_->eventHistory();
  there.intervals.event_history.moveBy(moved);
  setStateFromVoltage(there, first.time, first.current, first.voltage);
  const bool learns = tracker_->learns();
  tracker_.emplace(there, max_gap);
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
  if (auto crank = crank_watch_.add(sample, *tracker_, max_gap)) {
    compareWithBaseline(*crank);
    events.cranks.push_back(*crank);
    update(crank_calibration_, crank->measured_minimum, crank->expected_minimum);
    if (model_->fit.source)
      tracker_->updateFrom(
          PastCrank{crank->time, crank->current, crank->measured_minimum, crank->modelled_minimum});
  }
  if (auto charge = charge_watch_.add(sample, *tracker_, max_gap)) {
    compareWithBaseline(*charge, charge_selector_);
    events.charges.push_back(*charge);
    update(charge_calibration_, charge->measured_current, charge->expected_current);
    charge_voltages_.push_back(charge->mean_voltage);
    if (charge_voltages_.size() > kChargesKept) charge_voltages_.pop_front();
    updateFrom(*charge);
  }
  if (!model_->fit.source) return events;
  if (const auto stop = stop_watch_.add(sample, *tracker_, max_gap)) {
    events.stops.push_back(*stop);
    if (stop->duration == PastStop::kAge)
      tracker_->updateFrom(
          PastStop{stop->time, stop->current, stop->measured_voltage, stop->modelled_voltage});
  }
  if (auto charge = long_charge_watch_.add(sample, *tracker_, max_gap)) {
    compareWithBaseline(*charge, long_charge_selector_);
    updateFrom(*charge);
  }
  return events;
}

void ModelMonitor::updateFrom(const ChargeComparison& charge) {
  if (!model_->fit.source) return;
  tracker_->updateFrom(PastCharge{charge.time, charge.duration, charge.mean_voltage,
                                  charge.first_voltage, charge.measured_current,
                                  charge.modelled_current});
}

void ModelMonitor::compareWithBaseline(CrankComparison& crank) {
  const auto baseline = baselineCrankMinimum(model_->fit.baseline, crank.current);
  if (!baseline) return;
  crank.baseline_answered = crank_selector_.isBaselineSelected();
  crank.baseline_minimum =
      crank_selector_.add({crank.time,
                           crank.current,
                           0.0,
                           crank.measured_minimum,
                           crank.expected_minimum.value,
                           {baseline->value, baseline->lower, baseline->upper}});
}

void ModelMonitor::compareWithBaseline(ChargeComparison& charge, BaselineSelector& selector) const {
  const auto baseline =
      baselineChargeCurrent(model_->fit.baseline, charge.mean_voltage, charge.duration);
  if (!baseline) return;
  charge.baseline_answered = selector.isBaselineSelected();
  charge.baseline_current = selector.add({charge.time,
                                          charge.mean_voltage,
                                          charge.duration,
                                          charge.measured_current,
                                          charge.expected_current.value,
                                          {baseline->value, baseline->lower, baseline->upper}});
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
