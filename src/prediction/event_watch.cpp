#include "prediction/event_watch.hpp"

#include <cmath>
#include <utility>

#include "prediction/questions.hpp"
#include "recording/voltage_repair.hpp"

namespace battery_sof {
namespace {

constexpr double kAges[] = {PastEvent::kStopAge, 3.0 * PastEvent::kStopAge};  // [s]

/// Samples after a charge's last one until its voltage is known.
std::size_t waitsFor(const Fit& fit) { return fit.source ? fit.voltage_lag + 1 : 0; }

}  // namespace

WatchedSample EventWatch::advance(const Sample& sample, const StateTracker& before,
                                  double max_gap) {
  const bool is_gap = sample.time - before.state().time > max_gap;
  std::optional<double> min_current;
  if (before.hasSource()) {
    min_current = before.minCurrent();
    if (!before.isVoltageControlled()) detector_.denyCharge();
  }
  detector_.add(sample.time, sample.current, is_gap, min_current);
  return {sample, detector_, before, max_gap, is_gap};
}

std::optional<EventComparison> CrankWatch::add(const WatchedSample& at) {
  if (at.is_gap) model_.reset();
  if (!at.detector.isAtCrankLevel()) {
    const bool is_crank = model_ && at.detector.crankEnded();
    const auto comparison = is_crank ? compare() : std::nullopt;
    model_.reset();
    return comparison;
  }
  if (!model_) {
    model_ = at.before.modelNow();
    crank_ = {};
  }
  if (at.detector.mayBeCrank()) crank_.append(at.sample);
  return std::nullopt;
}

namespace {

/// The answer for a crank, where it is missed by more than its whole interval.
std::optional<MissedAnswer> missedBy(const PastEvent& crank, const std::optional<Interval>& u) {
  if (!u || std::abs(crank.measured - u->value) <= u->upper - u->lower) return std::nullopt;
  return MissedAnswer{crank.time, crank.measured, u->lower, u->upper};
}

}  // namespace

std::optional<EventComparison> CrankWatch::compare() {
  CrankingQuery query;
  query.crank = {crank_.time, crank_.current};
  for (double& time : query.crank.time) time -= model_->state.time;
  query.crank.time.insert(query.crank.time.begin(), 0.0);
  query.crank.current.insert(query.crank.current.begin(), model_->state.current);
  const double capacity = capacityFor(model_->fit, {});
  const CrankingAnswer answer = predictCranking(*model_, query, capacity);
  if (!answer.u_min) return std::nullopt;
  EventComparison comparison{measuredCrank(crank_, {0, crank_.size()}), *answer.u_min};
  FittedModel unexperienced = *model_;
  unexperienced.state.residual_state.present.current.reset();
  unexperienced.state.residual_state.colored = 0.0;
  missed_ = missedBy(comparison, answer.u_min);
  if (!missed_)
    missed_ = missedBy(comparison, predictCranking(unexperienced, query, capacity).u_min);
  unexperienced.state.residual_state.colored = model_->state.residual_state.colored;
  unexperienced.intervals.event_history = {};
  const CrankingAnswer by_model = predictCranking(unexperienced, query, capacity);
  if (!by_model.u_min) return std::nullopt;
  comparison.modelled = by_model.u_min->value;
  return comparison;
}

std::optional<EventComparison> ChargeWatch::add(const WatchedSample& at) {
  const StateTracker& before = at.before;
  const auto comparison = finishComplete(at);
  judgeLast(before);
  if (at.is_gap || !(before.hasSource() || at.detector.isCharging())) running_.reset();
  if (!running_ && at.detector.chargeBegins()) running_ = Charge{before.modelNow(), {}, 0, 0};
  if (!running_) return comparison;
  running_->samples.append(at.sample);
  if (at.sample.time - running_->model.state.time < compare_after_) return comparison;
  complete_ = std::exchange(running_, std::nullopt);
  complete_->own = complete_->samples.size();
  return waitsFor(complete_->model.fit) == 0 ? compare(*std::exchange(complete_, std::nullopt))
                                             : comparison;
}

/// The sample before this one was judged since: a charge that it began with the current controlled
/// has not begun, and one with too much of that is over. The model stands where the voltage before
/// the charge puts it, once that is known.
void ChargeWatch::judgeLast(const StateTracker& before) {
  if (!running_ || !running_->model.fit.source) return;
  if (before.last() && before.last()->time == running_->model.state.time)
    running_->model = before.modelSettled();
  if (before.isVoltageControlled()) {
    ++running_->controlled;
    return;
  }
  const std::size_t passed = running_->samples.size();
  const double interval =
      (running_->samples.time.back() - running_->model.state.time) / static_cast<double>(passed);
  if (passed > 1 && static_cast<double>(passed - running_->controlled) * interval <=
                        (1.0 - kMinControlled) * compare_after_)
    return;
  running_.reset();
}

std::optional<EventComparison> ChargeWatch::finishComplete(const WatchedSample& at) {
  if (!complete_) return std::nullopt;
  if (complete_->samples.size() == complete_->own && at.before.isVoltageControlled())
    ++complete_->controlled;
  if (!at.is_gap) complete_->samples.append(at.sample);
  if (!at.is_gap && complete_->samples.size() < complete_->own + waitsFor(complete_->model.fit))
    return std::nullopt;
  const Charge charge = *std::exchange(complete_, std::nullopt);
  if (static_cast<double>(charge.controlled) < kMinControlled * static_cast<double>(charge.own))
    return std::nullopt;
  return compare(charge);
}

EventComparison ChargeWatch::compare(const Charge& charge) {
  const Series own = slice(charge.samples, {0, charge.own});
  std::vector<double> driving;
  for (std::size_t n = 0; n < charge.own && charge.model.fit.source; ++n)
    driving.push_back(repairedVoltage(charge.samples, n, charge.model.fit.voltage_lag));
  return currentAtVoltage(charge.model, own, driving);
}

std::optional<EventComparison> StopWatch::add(const WatchedSample& at) {
  const Sample& sample = at.sample;
  if (!at.detector.isInStop()) running_.reset();
  if (at.detector.stopBegins()) running_.emplace(at.before.modelNow());
  if (!running_) return std::nullopt;
  Stop& stop = *running_;
  InputSample input;
  input.step = stop.estimator.stepTo(sample.time, sample.current, at.max_gap);
  input.voltage = sample.voltage;
  const FollowedSample followed = stop.estimator.predict(input);
  if (stop.compared == std::size(kAges)) return std::nullopt;
  if (!stop.modelled && sample.time - stop.model.state.time >= kAges[stop.compared]) {
    stop.modelled = followed;
    stop.waits = stop.model.fit.voltage_lag + 1;
  }
  if (!stop.modelled || --stop.waits > 0) return std::nullopt;
  const EventComparison comparison = compare(sample.voltage);
  stop.modelled.reset();
  ++stop.compared;
  return comparison;
}

EventComparison StopWatch::compare(double voltage) const {
  const Stop& stop = *running_;
  EventComparison comparison;
  comparison.kind = PastEvent::Kind::kStop;
  comparison.time = stop.model.state.time;
  comparison.duration = kAges[stop.compared];
  comparison.current = stop.modelled->current;
  comparison.measured = voltage;
  comparison.modelled = stop.modelled->voltage;
  const ErrorForecast error = ResidualFilter(stop.model).forecast(comparison.duration);
  const double value = stop.modelled->voltage + error.mean;
  comparison.expected = ninetyPercent(value, std::sqrt(stop.modelled->variance + error.variance));
  return comparison;
}

}  // namespace battery_sof
