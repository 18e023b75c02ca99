#include "prediction/charger_share.hpp"

namespace battery_sof {
namespace {

constexpr double kBlock = 10.0;  // [s]

}  // namespace

ChargerShare::ChargerShare(const ControlModeRule& rule)
    : seen_(rule.present), watch_(ControlModeDetector(rule)) {}

ChargerShare::ChargerShare(const Series& series, const ControlModes& source)
    : seen_(source.seen), watch_(ControlModeDetector(source.rule)) {
  for (std::size_t n = 0; n < series.size(); ++n) {
    if (series.time[n] >= series.time.back() - kControlModeLookBack)
      watch_->add(series.time[n], series.current[n], series.voltage[n]);
    count(series.time[n], source.voltage_controlled[n]);
  }
}

void ChargerShare::add(const StreamSample& sample) {
  if (watch_) count(sample.time, watch_->add(sample.time, sample.current, sample.voltage));
}

void ChargerShare::count(double time, bool controlled) {
  if (blocks_.empty() || time - blocks_.back().from > kBlock) blocks_.push_back({time, time, 0, 0});
  Block& block = blocks_.back();
  block.to = time;
  ++block.samples;
  if (controlled) ++block.controlled;
}

void ChargerShare::forgetBefore(double time) {
  while (!blocks_.empty() && blocks_.front().to < time) blocks_.pop_front();
}

void ChargerShare::forgetPast() { blocks_.clear(); }

std::optional<double> ChargerShare::share() const {
  std::size_t samples = 0, controlled = 0;
  for (const Block& block : blocks_) {
    samples += block.samples;
    controlled += block.controlled;
  }
  if (samples == 0) return std::nullopt;
  return static_cast<double>(controlled) / static_cast<double>(samples);
}

std::optional<double> ChargerShare::until() const {
  return blocks_.empty() ? std::nullopt : std::optional<double>(blocks_.back().to);
}

}  // namespace battery_sof
