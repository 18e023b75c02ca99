#include "prediction/charge_watch.hpp"

#include <utility>

#include "baseline/charge_phases.hpp"
#include "recording/voltage_repair.hpp"

namespace battery_sof {
namespace {

constexpr double kChargeCurrent = 2.0;  // [A], docs/physics.md#regimes
constexpr double kMinControlled = 0.9;  // share of samples, as beginningOfCharge()

void append(Series& series, const StreamSample& sample) {
  series.time.push_back(sample.time);
  series.current.push_back(sample.current);
  series.voltage.push_back(sample.voltage);
}

}  // namespace

void ChargeWatch::reset() {
  running_.reset();
  complete_.reset();
  charging_ = discharged_ = false;
}

void ChargeWatch::beginBehind(double current) {
  reset();
  charging_ = current > kChargeCurrent;
  discharged_ = current < kDischargeCurrent;
}

/// Samples after a charge's last one until its voltage is known.
std::size_t ChargeWatch::waitsFor(const Fit& fit) { return fit.source ? fit.voltage_lag + 1 : 0; }

std::optional<ChargeComparison> ChargeWatch::add(const StreamSample& sample,
                                                 const StateTracker& before, double max_gap) {
  const bool is_gap = sample.time - before.state().time > max_gap;
  const auto comparison = finishComplete(sample, before, is_gap);
  judgeLast(before);
  if (is_gap || isOver(sample, before)) {
    running_.reset();
    charging_ = false;
    discharged_ = sample.current < kDischargeCurrent;
    return comparison;
  }
  if (begins(sample, before)) running_ = Charge{before.modelNow(), before.missed(), {}, 0, 0};
  if (!running_) return comparison;
  append(running_->samples, sample);
  if (sample.time - running_->model.state.time < compare_after_) return comparison;
  complete_ = std::exchange(running_, std::nullopt);
  complete_->own = complete_->samples.size();
  return waitsFor(complete_->model.fit) == 0 ? compare(*std::exchange(complete_, std::nullopt))
                                             : comparison;
}

bool ChargeWatch::isOver(const StreamSample& sample, const StateTracker& before) const {
  return !before.hasSource() && sample.current <= kChargeCurrent;
}

bool ChargeWatch::begins(const StreamSample& sample, const StateTracker& before) {
  const bool began =
      before.hasSource() ? !running_ && discharged_ && sample.current > 0.0 : !charging_;
  if (sample.current < kDischargeCurrent) discharged_ = true;
  if (sample.current > 0.0) discharged_ = false;
  charging_ = sample.current > kChargeCurrent;
  return began;
}

/// The sample before this one was judged since: a charge that it began with the current controlled
/// has not begun, and one with too much of that is over. The model stands where the voltage before
/// the charge puts it, once that is known.
void ChargeWatch::judgeLast(const StateTracker& before) {
  if (!running_ || !running_->model.fit.source) return;
  if (before.lastTime() == running_->model.state.time) {
    running_->model = before.modelSettled();
    running_->missed = before.missedSettled();
  }
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
  discharged_ = discharged_ || passed == 1;
}

std::optional<ChargeComparison> ChargeWatch::finishComplete(const StreamSample& sample,
                                                            const StateTracker& before,
                                                            bool is_gap) {
  if (!complete_) return std::nullopt;
  if (complete_->samples.size() == complete_->own && before.isVoltageControlled())
    ++complete_->controlled;
  if (!is_gap) append(complete_->samples, sample);
  if (!is_gap && complete_->samples.size() < complete_->own + waitsFor(complete_->model.fit))
    return std::nullopt;
  const Charge charge = *std::exchange(complete_, std::nullopt);
  if (static_cast<double>(charge.controlled) < kMinControlled * static_cast<double>(charge.own))
    return std::nullopt;
  return compare(charge);
}

ChargeComparison ChargeWatch::compare(const Charge& charge) {
  const Series own = slice(charge.samples, {0, charge.own});
  std::vector<double> driving;
  for (std::size_t n = 0; n < charge.own && charge.model.fit.source; ++n)
    driving.push_back(repairedVoltage(charge.samples, n, charge.model.fit.voltage_lag));
  const MeanChargeCurrent expected = currentAtVoltage(charge.model, own, charge.missed, driving);
  ChargeComparison comparison;
  comparison.time = own.time.front();
  comparison.duration = own.time.back() - charge.model.state.time;
  comparison.expected_current = expected.current;
  comparison.modelled_current = expected.modelled;
  comparison.mean_voltage = expected.mean_voltage;
  comparison.measured_current = expected.measured;
  comparison.first_voltage = own.voltage.front();
  return comparison;
}

}  // namespace battery_sof
