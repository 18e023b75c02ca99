#include "battery_sof/predict/tracked_model.hpp"

#include "battery_sof/identify/fit_quality.hpp"

namespace battery_sof {

TrackedModel::TrackedModel(const EventLimits& limits) : crank_watch_(limits) {}

void TrackedModel::install(const FittedModel& model, double max_gap) {
  model_ = model;
  fitted_until_ = model.window.to;
  compared_.clear();
  tracker_.emplace(model, max_gap);
  tracker_->setScales(crank_scale_, charge_scale_);
}

void TrackedModel::forgetPast() {
  crank_watch_.reset();
  charge_watch_.reset();
  compared_.clear();
}

void TrackedModel::moveTo(const StreamSample& first, double moved, double max_gap) {
  forgetPast();
  if (!model_) return;
  fitted_until_ += moved;
  FittedModel there = *model_;
  setStateFromVoltage(there, first.time, first.current, first.voltage);
  tracker_.emplace(there, max_gap);
}

void TrackedModel::setScales(const IntervalScale& crank, const IntervalScale& charge) {
  crank_scale_ = crank;
  charge_scale_ = charge;
  if (tracker_) tracker_->setScales(crank, charge);
}

SessionEvents TrackedModel::follow(const StreamSample& sample, double max_gap) {
  if (!tracker_ || sample.time <= tracker_->state().time) return {};
  SessionEvents events = watch(sample, max_gap);
  tracker_->setScales(crank_scale_, charge_scale_);
  tracker_->follow(sample.time, sample.current, sample.voltage);
  if (!tracker_->last().voltage_drives)
    compared_.push_back({sample.time, sample.voltage, tracker_->last().voltage});
  while (!compared_.empty() && compared_.front().time < sample.time - kBacktestSpan) compared_.pop_front();
  return events;
}

SessionEvents TrackedModel::watch(const StreamSample& sample, double max_gap) {
  SessionEvents events;
  if (const auto crank = crank_watch_.add(sample, *tracker_, max_gap)) {
    events.cranks.push_back(*crank);
    observe(crank_scale_, crank->measured_minimum, crank->expected_minimum);
    if (model_->source)
      tracker_->learnFrom(
          PastCrank{crank->time, crank->current, crank->measured_minimum, crank->modelled_minimum});
  }
  if (const auto charge = charge_watch_.add(sample, *tracker_, max_gap)) {
    events.charges.push_back(*charge);
    observe(charge_scale_, charge->measured_current, charge->expected_current);
    if (model_->source)
      tracker_->learnFrom(PastCharge{charge->time, charge->duration, charge->mean_voltage,
                                     charge->first_voltage, charge->measured_current, charge->modelled_current});
  }
  return events;
}

BacktestScore TrackedModel::backtest() const {
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
