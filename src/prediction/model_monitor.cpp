#include "prediction/model_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "estimation/fit_quality.hpp"
#include "prediction/pipeline.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kChargesKept = 20;     // whose voltage is kept
constexpr double kBlock = 10.0;              // [s], of ModelSelector
constexpr double kClearlyBetter = 0.95;      // of the RMSE
constexpr double kToleratedWorsening = 1.1;  // as OnlineSession tolerates of a new model
constexpr int kMinEvents = 3;
constexpr double kDenialLookInterval = 1.0;  // [s], whether a model is denied

double blockOf(double time) { return std::floor(time / kBlock); }

}  // namespace

void ModelMonitor::install(const FittedModel& model, double max_gap) {
  model_ = model;
  fitted_until_ = model.fit.window.to;
  compared_.clear();
  is_denied_ = false;
  looked_at_ = -HUGE_VAL;
  if (!steps_.event_history) model_->intervals.event_history = {};
  tracker_.emplace(*model_, max_gap, steps_.residual_filter);
  tracker_->setCalibrations(calibrations_);
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
  tracker_->setCalibrations(calibrations_);
  watch_ = other.watch_;
  is_denied_ = other.is_denied_;
  looked_at_ = other.looked_at_;
}

void ModelMonitor::lookBack(const Series& series) {
  tracker_->lookBack(series);
  watch_.beginBehind(tracker_->state().current);
}

void ModelMonitor::forgetPast() {
  watch_.reset();
  compared_.clear();
}

void ModelMonitor::moveTo(const Sample& first, double moved, double max_gap) {
  forgetPast();
  if (!model_) return;
  fitted_until_ += moved;
  looked_at_ = -HUGE_VAL;
  FittedModel there = *model_;
  there.intervals.event_history = tracker_->eventHistory();
  there.intervals.event_history.moveBy(moved);
  setStateFromVoltage(there, first.time, first.current, first.voltage);
  const bool learns = tracker_->learns();
  tracker_.emplace(there, max_gap, steps_.residual_filter);
  if (learns) tracker_->learn();
  tracker_->setCalibrations(calibrations_);
}

void ModelMonitor::setCalibrations(const IntervalCalibrations& calibrations) {
  calibrations_ = calibrations;
  if (tracker_) tracker_->setCalibrations(calibrations);
}

SessionEvents ModelMonitor::follow(const Sample& sample, double max_gap) {
  if (!tracker_ || sample.time <= tracker_->state().time) return {};
  SessionEvents events = watch(sample, max_gap);
  tracker_->setCalibrations(calibrations_);
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

SessionEvents ModelMonitor::watch(const Sample& sample, double max_gap) {
  SessionEvents events;
  const WatchedSample at = watch_.moveTo(sample, *tracker_, max_gap);
  const auto take = [&](EventComparison event, IntervalCalibration& calibration,
                        std::vector<EventComparison>& of_kind) {
    event.baseline = expectedBy(model_->fit.baseline, event);
    of_kind.push_back(event);
    if (steps_.calibration) update(calibration, event.measured, event.expected);
    updateFrom(event);
  };
  if (const auto crank = watch_.cranks.add(at)) {
    tracker_->setMissedAnswer(watch_.cranks.missed());
    take(*crank, calibrations_.crank_calibration, events.cranks);
  }
  if (const auto charge = watch_.charges.add(at)) {
    charge_voltages_.push_back(charge->voltage);
    if (charge_voltages_.size() > kChargesKept) charge_voltages_.pop_front();
    take(*charge, calibrations_.charge_calibration, events.charges);
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

void ModelSelector::Errors::add(double base_error, double extended_error) {
  ++count;
  base += base_error;
  extended += extended_error;
}

void ModelSelector::Errors::add(const Errors& other) {
  count += other.count;
  base += other.base;
  extended += other.extended;
}

bool ModelSelector::Errors::isExtendedWorse(double negligible) const {
  if (count < kMinEvents) return false;
  return extended > kToleratedWorsening * base && extended - base > negligible * count;
}

void ModelSelector::add(const Sample& sample, const ModelMonitor& base,
                        const SessionEvents& base_events, const ModelMonitor& extended,
                        const SessionEvents& extended_events) {
  const double interval = blocks_.empty() ? 0.0 : sample.time - blocks_.back().to;
  if (blocks_.empty() || blockOf(sample.time) != blockOf(blocks_.back().from)) {
    if (score().duration >= kMinDuration) extended_answers_ = isExtendedBetter();
    blocks_.push_back({sample.time, sample.time, 0.0, {}, {}, {}});
    while (blocks_.front().to < sample.time - ModelMonitor::kBacktestSpan) blocks_.pop_front();
  }
  Block& block = blocks_.back();
  block.to = sample.time;
  if (interval <= kBlock) block.duration += interval;
  if (base.tracker().last() && extended.tracker().last())
    block.squares.add(std::pow(base.tracker().error(), 2), std::pow(extended.tracker().error(), 2));
  if (!base_events.cranks.empty() && !extended_events.cranks.empty())
    block.cranks.add(base_events.cranks[0].absError(), extended_events.cranks[0].absError());
  if (!base_events.charges.empty() && !extended_events.charges.empty())
    block.charges.add(base_events.charges[0].absError(), extended_events.charges[0].absError());
}

ModelSelector::Block ModelSelector::total() const {
  Block sum;
  for (const Block& block : blocks_) {
    sum.duration += block.duration;
    sum.squares.add(block.squares);
    sum.cranks.add(block.cranks);
    sum.charges.add(block.charges);
  }
  return sum;
}

ModelSelectorScore ModelSelector::score() const {
  const Block sum = total();
  const double count = std::max(1, sum.squares.count);
  return {sum.duration, std::sqrt(sum.squares.base / count),
          std::sqrt(sum.squares.extended / count)};
}

bool ModelSelector::isExtendedBetter() const {
  const Block sum = total();
  const double margin = extended_answers_ ? 1.0 : kClearlyBetter;
  return std::sqrt(sum.squares.extended) < margin * std::sqrt(sum.squares.base) &&
         !sum.cranks.isExtendedWorse(kNegligibleVoltage) &&
         !sum.charges.isExtendedWorse(kNegligibleCurrent);
}

}  // namespace battery_sof
