#include "battery_sof/predict/charge_watch.hpp"

#include <utility>

#include "battery_sof/recording/voltage_repair.hpp"

namespace battery_sof {
namespace {

constexpr double kChargeCurrent = 2.0;  // [A], PHYSICS 2.2 (long charge)
constexpr double kCompareAfter = 10.0;  // [s], the same

void append(Series& series, const StreamSample& sample) {
  series.time.push_back(sample.time);
  series.current.push_back(sample.current);
  series.voltage.push_back(sample.voltage);
}

}  // namespace

void ChargeWatch::reset() {
  running_.reset();
  complete_.reset();
  charging_ = false;
}

void ChargeWatch::beginBehind(double current) {
  reset();
  charging_ = current > kChargeCurrent;
}

/// Samples after a charge's last one until its voltage is known.
std::size_t ChargeWatch::waitsFor(const FittedModel& model) { return model.source ? model.voltage_lag + 1 : 0; }

std::optional<ChargeComparison> ChargeWatch::add(const StreamSample& sample,
                                                 const StateTracker& before, double max_gap) {
  const bool is_gap = sample.time - before.state().time > max_gap;
  const auto comparison = finishComplete(sample, is_gap);
  if (sample.current <= kChargeCurrent || is_gap) {
    running_.reset();
    charging_ = false;
    return comparison;
  }
  if (!charging_) {
    charging_ = true;
    running_ = Charge{before.modelNow(), before.missed(), {}, 0};
  }
  if (!running_) return comparison;
  append(running_->samples, sample);
  if (sample.time - running_->model.state.time < kCompareAfter) return comparison;
  complete_ = std::exchange(running_, std::nullopt);
  complete_->own = complete_->samples.size();
  return waitsFor(complete_->model) == 0 ? compare(*std::exchange(complete_, std::nullopt)) : comparison;
}

std::optional<ChargeComparison> ChargeWatch::finishComplete(const StreamSample& sample, bool is_gap) {
  if (!complete_) return std::nullopt;
  if (!is_gap) append(complete_->samples, sample);
  if (!is_gap && complete_->samples.size() < complete_->own + waitsFor(complete_->model)) return std::nullopt;
  return compare(*std::exchange(complete_, std::nullopt));
}

ChargeComparison ChargeWatch::compare(const Charge& charge) {
  const Series own = slice(charge.samples, {0, charge.own});
  std::vector<double> driving;
  for (std::size_t n = 0; n < charge.own && charge.model.source; ++n)
    driving.push_back(repairedVoltage(charge.samples, n, charge.model.voltage_lag));
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
