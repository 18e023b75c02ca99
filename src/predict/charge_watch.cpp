#include "battery_sof/predict/charge_watch.hpp"

namespace battery_sof {
namespace {

constexpr double kChargeCurrent = 2.0;  // [A], PHYSICS 2.2 (long charge)
constexpr double kCompareAfter = 10.0;  // [s], the same

}  // namespace

void ChargeWatch::reset() {
  model_.reset();
  charging_ = false;
}

std::optional<ChargeComparison> ChargeWatch::add(const StreamSample& sample,
                                                 const StateTracker& before, double max_gap) {
  if (sample.current <= kChargeCurrent || sample.time - before.state().time > max_gap) {
    reset();
    return std::nullopt;
  }
  if (!charging_) {
    charging_ = true;
    model_ = before.modelNow();
    missed_ = before.missed();
    charge_ = {};
  }
  if (!model_) return std::nullopt;
  charge_.time.push_back(sample.time);
  charge_.current.push_back(sample.current);
  charge_.voltage.push_back(sample.voltage);
  const double duration = sample.time - model_->state.time;
  if (duration < kCompareAfter) return std::nullopt;
  ChargeComparison comparison;
  comparison.time = charge_.time.front();
  comparison.duration = duration;
  const MeanChargeCurrent expected = currentAtVoltage(*model_, charge_, missed_);
  comparison.expected_current = expected.current;
  comparison.modelled_current = expected.modelled;
  comparison.mean_voltage = expected.mean_voltage;
  comparison.measured_current = expected.measured;
  comparison.first_voltage = charge_.voltage.front();
  model_.reset();
  return comparison;
}

}  // namespace battery_sof
