#include "prediction/frozen_channels.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "recording/events.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kLeast = 30.0;    // [s]
constexpr int kLeastSamples = 10;  // as the stuck check of a recording
constexpr double kBeyond = 10.0;   // times what was seen before
constexpr double kMoved = 3.0;     // times, beyond what noise adds in a longer stretch
constexpr double kLearnt = 300.0;  // [s]

}  // namespace

void FrozenChannels::Run::add(bool repeats, double interval, double other) {
  if (!repeats) end();
  if (samples == 0 && !repeats) {
    lowest = highest = other;
    return;
  }
  duration += interval;
  rise = std::max(rise, other - lowest);
  fall = std::max(fall, highest - other);
  lowest = std::min(lowest, other);
  highest = std::max(highest, other);
  ++samples;
}

void FrozenChannels::Run::end() {
  if (!isLong() || duration <= kBeyond * longest ||
      (moved() > 0.0 && moved() <= kMoved * max_moved)) {
    longest = std::max(longest, duration);
    max_moved = std::max(max_moved, moved());
  }
  duration = rise = fall = 0.0;
  samples = 0;
}

bool FrozenChannels::Run::isLong() const { return duration >= kLeast && samples >= kLeastSamples; }

void FrozenChannels::add(const Sample& sample, bool is_gap) {
  if (!last_ || is_gap) {
    for (Run* run : {&both_, &current_, &voltage_}) run->end();
  } else {
    const double interval = sample.time - last_->time,
                 current_moved = std::abs(sample.current - last_->current),
                 voltage_moved = std::abs(sample.voltage - last_->voltage);
    const bool at_rest = std::abs(sample.current) < EventLimits::kRestCurrent;
    learnt_ += interval;
    both_.add(current_moved == 0.0 && voltage_moved == 0.0 && !at_rest, interval, 0.0);
    current_.add(current_moved == 0.0, interval, sample.voltage);
    voltage_.add(voltage_moved == 0.0, interval, sample.current);
  }
  last_ = sample;
  reason_ = judge();
}

std::string FrozenChannels::judge() const {
  if (both_.isLong() && both_.duration > kBeyond * both_.longest)
    return format("current and voltage have repeated themselves for %.0f s", both_.duration);
  if (learnt_ < kLearnt) return "";
  for (const auto& [run, name] : {std::pair{&voltage_, "voltage"}, std::pair{&current_, "current"}})
    if (run->isLong() && run->duration > kBeyond * run->longest &&
        run->moved() > kMoved * run->max_moved)
      return format("the %s has been stuck for %.0f s while the other channel moved up and down",
                    name, run->duration);
  return "";
}

}  // namespace battery_sof
