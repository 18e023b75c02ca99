#include "prediction/stream_watch.hpp"

#include <cmath>

#include "recording/frozen_channels.hpp"
#include "recording/series_blocks.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kMemory = 600.0;      // [s]; a stop of minutes with tiny currents is a part of it
constexpr double kMostly = 0.5;        // of the time
constexpr double kConvinced = 10.0;    // [s], a crank lasts no longer
constexpr double kLookInterval = 1.0;  // [s]
constexpr double kQuietRate = 0.05;    // [1/h], the 20 h rate
// [V] of a block: no charger holds a 12 V battery above it, and more is beyond every question too
constexpr double kHighest = 16.0;
constexpr double kLowest = 9.0;  // [V] of a block, 1.5 V a cell

}  // namespace

void StreamWatch::pass(double time, double max_gap, bool is_refused) {
  const double interval = last_ ? time - *last_ : 0.0;
  longest_joined_ = max_gap;
  if (interval < 0.0) return;
  last_ = time;
  if (interval > max_gap) return;
  const double kept = std::exp(-interval / kMemory);
  offered_ = kept * offered_ + interval;
  refused_ = kept * refused_ + (is_refused ? interval : 0.0);
}

void StreamWatch::refuse(double time, double max_gap) { pass(time, max_gap, true); }

void StreamWatch::accept(const Sample& sample, double max_gap) {
  pass(sample.time, max_gap, false);
  last_taken_ = sample.time;
  judgeBlocks(sample);
}

void StreamWatch::judgeBlocks(const Sample& sample) {
  const bool is_quiet = std::abs(sample.current) <= kQuietRate * battery_.capacity;
  const bool is_low = sample.voltage < kLowest;
  if (is_low && !is_quiet) return;
  const bool fits = !is_low && sample.voltage <= kHighest;
  if (!fits) voltage_ = sample.voltage;
  if (!fits_) fits_ = fits;
  if (fits == *fits_) {
    otherwise_since_.reset();
    return;
  }
  if (!otherwise_since_) otherwise_since_ = sample.time;
  if (sample.time - *otherwise_since_ < kConvinced) return;
  fits_ = fits;
  otherwise_since_.reset();
}

void StreamWatch::look(const Series& series, double max_gap) {
  if (series.empty()) return;
  const double now = series.time.back();
  if (doubted_voltage_ && series.voltage.back() != *doubted_voltage_) doubted_voltage_.reset();
  if (doubted_current_ && series.current.back() != *doubted_current_) doubted_current_.reset();
  if (looked_ && now >= *looked_ && now - *looked_ < kLookInterval) return;
  looked_ = now;
  frozen_ = frozenChannels(series, battery_.capacity, max_gap);
}

void StreamWatch::doubt(const Series& series, double max_gap) {
  if (series.empty()) return;
  const double now = series.time.back();
  if (doubted_at_ && now >= *doubted_at_ && now - *doubted_at_ < kLookInterval) return;
  doubted_at_ = now;
  const RepeatingChannels repeating = repeatingChannels(series, battery_.capacity, max_gap);
  if (repeating.current) doubted_current_ = series.current.back();
  if (repeating.voltage) doubted_voltage_ = series.voltage.back();
}

void StreamWatch::forgetClock() {
  last_.reset();
  last_taken_.reset();
  otherwise_since_.reset();
  looked_.reset();
  frozen_.reset();
  doubted_current_.reset();
  doubted_voltage_.reset();
  doubted_at_.reset();
}

std::optional<std::string> StreamWatch::whyNotValid(const std::string& reasons) const {
  std::optional<std::string> why = whyRefused(reasons);
  if (!why) why = whyOtherBlocks();
  if (!why) why = frozen_;
  return why ? why : whyDoubted();
}

std::optional<std::string> StreamWatch::whyDoubted() const {
  if (doubted_voltage_)
    return format("the voltage of a block has read exactly %g V since the model missed it",
                  *doubted_voltage_);
  if (doubted_current_)
    return format("the current has read exactly %g A since the model missed the voltage",
                  *doubted_current_);
  return std::nullopt;
}

std::optional<std::string> StreamWatch::whyRefused(const std::string& reasons) const {
  const std::string counts = reasons.empty() ? "" : " (since the start: " + reasons + ")";
  if (refused_ > kMostly * offered_)
    return format("%.0f %% of the samples of the last minutes were rejected",
                  100.0 * refused_ / offered_) +
           counts + "; current and voltage are expected in A and V";
  if (last_ && last_taken_ && *last_ - *last_taken_ > longest_joined_)
    return format("every sample of the last %.0f s was rejected", *last_ - *last_taken_) + counts;
  return std::nullopt;
}

std::optional<std::string> StreamWatch::whyOtherBlocks() const {
  if (fits_.value_or(true)) return std::nullopt;
  const double voltage = battery_.series_blocks * voltage_;
  const auto [blocks, row] = seriesThatFits(voltage);
  return format("the voltage, %.2f V, is not that of a battery with series_blocks %g: ", voltage,
                battery_.series_blocks) +
         (row.empty() ? "the battery or its sensor is faulty, or series_blocks is another"
                      : "it could be " + row + format(" (series_blocks %g)", blocks));
}

}  // namespace battery_sof
