#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "battery_sof/series.hpp"

namespace battery_sof {

/**
 * @brief Notices channels that repeat a value for far longer than they ever did.
 *
 * Current and voltage under load flicker by noise and steps of the sensor. Both are frozen when
 * they repeat themselves exactly, away from rest, for half a minute and ten times as long as the
 * longest such stretch before. One of them is stuck when it does so while the other moves up and
 * down by three times as much as in any such stretch before; five minutes are the past it needs. What
 * was judged frozen does not count.
 */
class FrozenChannels {
 public:
  /// Takes a sample later than the one before. @param is_gap behind a longer interval.
  void add(const Sample& sample, bool is_gap);

  /// One sentence; empty while the channels are alive.
  const std::string& reason() const { return reason_; }

 private:
  /// A stretch in which a value repeats, and the longest of those that ended.
  struct Run {
    double duration = 0.0, longest = 0.0;  // [s]
    // by which the other channel rose and fell, the lesser of both; of the past
    double rise = 0.0, fall = 0.0, max_moved = 0.0;
    double lowest = 0.0, highest = 0.0;  // of the other channel
    int samples = 0;
    double moved() const { return std::min(rise, fall); }
    /// Takes a sample. @param other channel's value.
    void add(bool repeats, double interval, double other);
    void end();
    bool isLong() const;
  };

  std::string judge() const;

  std::optional<Sample> last_;
  double learnt_ = 0.0;  // [s]
  Run both_, current_, voltage_;
  std::string reason_;
};

}  // namespace battery_sof
