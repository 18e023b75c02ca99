#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <random>

#include "simulator/numerics.hpp"

namespace battery_sof_simulator {

/// Lowest and highest value of something drawn at random.
struct Range {
  double low, high;
};

/// Seeded random numbers; the same seed and stream give the same numbers.
class Dice {
 public:
  /// @param stream one for each purpose, so that more numbers of one leave the others as they are.
  Dice(std::uint64_t seed, std::uint32_t stream) {
    std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                           stream};
    engine_.seed(sequence);
  }

  /// Numbers of one purpose alone.
  explicit Dice(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [0, 1).
  double share() { return std::generate_canonical<double, 53>(engine_); }
  double between(const Range& range) { return range.low + (range.high - range.low) * share(); }
  /// Uniform in the logarithm; both ends above 0.
  double logBetween(const Range& range) {
    return range.low * std::pow(range.high / range.low, share());
  }
  double sign() { return share() < 0.5 ? -1.0 : 1.0; }
  double normal() { return normal_(engine_); }  ///< mean 0, standard deviation 1
  /// One of several, each as likely.
  template <typename Choices>
  auto oneOf(const Choices& choices) {
    return choices[static_cast<std::size_t>(share() * static_cast<double>(std::size(choices)))];
  }

  /// A number of the range, leaning to one end: low + (high - low) x^(2^lean), x uniform.
  /// @param lean 0 uniform, positive towards low, negative towards high; -4 to 4 at most.
  double leaning(const Range& range, double lean) {
    const double exponent = std::exp2(std::clamp(lean, -4.0, 4.0));
    return range.low + (range.high - range.low) * std::pow(share(), exponent);
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_{0.0, 1.0};
};

/// Noise of one channel (docs/physics.md#noise-of-a-residual), the sum of three parts.
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
