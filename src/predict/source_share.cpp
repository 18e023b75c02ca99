#include "battery_sof/predict/source_share.hpp"

namespace battery_sof {
namespace {

constexpr double kBlock = 10.0;      // [s]
constexpr double kLookBack = 300.0;  // [s], of a source's past that its judgement rests on, as driveOf()

}  // namespace

SourceShare::SourceShare(const SourceRule& rule) : seen_(rule.present), watch_(SourceWatch(rule)) {}

SourceShare::SourceShare(const Series& series, const Source& source) : seen_(source.seen), watch_(SourceWatch(source.rule)) {
  for (std::size_t n = 0; n < series.size(); ++n) {
    if (series.time[n] >= series.time.back() - kLookBack) watch_->add(series.time[n], series.current[n], series.voltage[n]);
    count(series.time[n], source.imposes_voltage[n]);
  }
}

void SourceShare::add(const StreamSample& sample) {
  if (watch_) count(sample.time, watch_->add(sample.time, sample.current, sample.voltage));
}

void SourceShare::count(double time, bool imposed) {
  if (blocks_.empty() || time - blocks_.back().from > kBlock) blocks_.push_back({time, time, 0, 0});
  Block& block = blocks_.back();
  block.to = time;
  ++block.samples;
  if (imposed) ++block.imposed;
}

void SourceShare::forgetBefore(double time) {
  while (!blocks_.empty() && blocks_.front().to < time) blocks_.pop_front();
}

void SourceShare::forgetPast() { blocks_.clear(); }

std::optional<double> SourceShare::share() const {
  std::size_t samples = 0, imposed = 0;
  for (const Block& block : blocks_) {
    samples += block.samples;
    imposed += block.imposed;
  }
  if (samples == 0) return std::nullopt;
  return static_cast<double>(imposed) / static_cast<double>(samples);
}

std::optional<double> SourceShare::until() const { return blocks_.empty() ? std::nullopt : std::optional<double>(blocks_.back().to); }

}  // namespace battery_sof
