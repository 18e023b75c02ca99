#include "battery_sof/predict/tracked_model.hpp"

#include "battery_sof/identify/fit_quality.hpp"
#include "battery_sof/predict/experienced.hpp"

namespace battery_sof {

TrackedModel::TrackedModel(const EventLimits& limits) : crank_watch_(limits) {}

void TrackedModel::install(const FittedModel& model, double max_gap) {
  model_ = model;
  fitted_until_ = model.fit.window.to;
  compared_.clear();
  tracker_.emplace(model, max_gap);
  tracker_->setScales(crank_scale_, charge_scale_);
}

void TrackedModel::goOnAs(const TrackedModel& other, const FittedModel& model) {
  model_ = model;
  fitted_until_ = model.fit.window.to;
  compared_.clear();
  tracker_ = other.tracker_;
  tracker_->setOrigin(model.provenance);
  tracker_->setScales(crank_scale_, charge_scale_);
  crank_watch_ = other.crank_watch_;
  charge_watch_ = other.charge_watch_;
  long_charge_watch_ = other.long_charge_watch_;
}

void TrackedModel::lookBack(const Series& series) {
  tracker_->lookBack(series);
  charge_watch_.beginBehind(tracker_->state().current);
  long_charge_watch_.beginBehind(tracker_->state().current);
  crank_watch_.reset();
}

void TrackedModel::forgetPast() {
  crank_watch_.reset();
  charge_watch_.reset();
  long_charge_watch_.reset();
  compared_.clear();
}

void TrackedModel::moveTo(const StreamSample& first, double moved, double max_gap) {
  forgetPast();
  crank_contest_.moveBy(moved);
  charge_contest_.moveBy(moved);
  long_charge_contest_.moveBy(moved);
  if (!model_) return;
  fitted_until_ += moved;
  FittedModel there = *model_;
  there.intervals.experience = tracker_->experience();
  there.intervals.experience.moveBy(moved);
  setStateFromVoltage(there, first.time, first.current, first.voltage);
  tracker_.emplace(there, max_gap);
  tracker_->setScales(crank_scale_, charge_scale_);
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
  const bool settled = tracker_->follow(sample.time, sample.current, sample.voltage);
  if (settled && !tracker_->last().voltage_drives)
    compared_.push_back({tracker_->lastTime(), tracker_->lastVoltage(), tracker_->last().voltage});
  while (!compared_.empty() && compared_.front().time < sample.time - kBacktestSpan) compared_.pop_front();
  return events;
}

SessionEvents TrackedModel::watch(const StreamSample& sample, double max_gap) {
  SessionEvents events;
  if (auto crank = crank_watch_.add(sample, *tracker_, max_gap)) {
    setBesideNaive(*crank);
    events.cranks.push_back(*crank);
    observe(crank_scale_, crank->measured_minimum, crank->expected_minimum);
    if (model_->fit.source) tracker_->learnFrom(PastCrank{crank->time, crank->current, crank->measured_minimum, crank->modelled_minimum});
  }
  if (auto charge = charge_watch_.add(sample, *tracker_, max_gap)) {
    setBesideNaive(*charge, charge_contest_);
    events.charges.push_back(*charge);
    observe(charge_scale_, charge->measured_current, charge->expected_current);
    charge_voltages_.push_back(charge->mean_voltage);
    if (charge_voltages_.size() > kChargesKept) charge_voltages_.pop_front();
    learnFrom(*charge);
  }
  if (!model_->fit.source) return events;
  if (auto charge = long_charge_watch_.add(sample, *tracker_, max_gap)) {
    setBesideNaive(*charge, long_charge_contest_);
    learnFrom(*charge);
  }
  return events;
}

void TrackedModel::learnFrom(const ChargeComparison& charge) {
  if (!model_->fit.source) return;
  tracker_->learnFrom(PastCharge{charge.time, charge.duration, charge.mean_voltage, charge.first_voltage, charge.measured_current,
                                 charge.modelled_current});
}

void TrackedModel::setBesideNaive(CrankComparison& crank) {
  const auto naive = naiveCrankMinimum(model_->fit.naive, crank.current);
  if (!naive) return;
  crank.naive_answered = crank_contest_.doesNaiveAnswer();
  crank.naive_minimum = crank_contest_.add(
      {crank.time, crank.current, 0.0, crank.measured_minimum, crank.expected_minimum.value, {naive->value, naive->lower, naive->upper}});
}

void TrackedModel::setBesideNaive(ChargeComparison& charge, NaiveContest& contest) const {
  const auto naive = naiveChargeCurrent(model_->fit.naive, charge.mean_voltage, charge.duration);
  if (!naive) return;
  charge.naive_answered = contest.doesNaiveAnswer();
  charge.naive_current = contest.add({charge.time,
                                      charge.mean_voltage,
                                      charge.duration,
                                      charge.measured_current,
                                      charge.expected_current.value,
                                      {naive->value, naive->lower, naive->upper}});
}

std::optional<double> TrackedModel::chargeVoltage() const {
  if (tracker_)
    if (const auto known = usualVoltage(tracker_->experience().charges)) return known;
  if (charge_voltages_.empty()) return std::nullopt;
  return medianOf({charge_voltages_.begin(), charge_voltages_.end()});
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
