#pragma once

#include <cmath>

#include "simulator/dice.hpp"
#include "simulator/units.hpp"

namespace battery_sof_simulator {

/// Noise of one channel (docs/physics.md#noise-of-a-residual): white, first-order autoregressive
/// and a random walk, added up.
struct NoiseOptions {
  double white = 0.0;              ///< standard deviation a sample [V or A]
  double correlated = 0.0;         ///< standard deviation of the autoregressive part [V or A]
  double correlation_time = 2.0;   ///< its time constant [s], > 0
  double walk_per_sqrt_min = 0.0;  ///< standard deviation of the walk after one minute [V or A]
};

/// To the nearest step; 0 leaves the value as it is.
inline double quantised(double value, double step) {
  return step > 0.0 ? step * std::round(value / step) : value;
}

/// The noise of one channel, sample by sample.
class ChannelNoise {
 public:
  /// @param interval between samples [s], > 0.
  ChannelNoise(const NoiseOptions& options, double interval, Dice dice)
      : options_(options),
        memory_(std::exp(-interval / options.correlation_time)),
        walk_step_(options.walk_per_sqrt_min * std::sqrt(interval / kSecondsPerMinute)),
        dice_(dice),
        correlated_(options.correlated * dice_.normal()) {}

  double next() {
    const double now = options_.white * dice_.normal() + correlated_ + walk_;
    correlated_ = memory_ * correlated_ +
                  options_.correlated * std::sqrt(1.0 - memory_ * memory_) * dice_.normal();
    walk_ += walk_step_ * dice_.normal();
    return now;
  }

 private:
  NoiseOptions options_;
  double memory_, walk_step_;
  Dice dice_;
  double correlated_;
  double walk_ = 0.0;
};

}  // namespace battery_sof_simulator
