#pragma once

#include <cstdint>

namespace battery_sof {

/// Random numbers for tests by simulation: the same on every machine (SplitMix64; Steele, Lea and
/// Flood 2014).
class RandomBits {
 public:
  explicit RandomBits(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }

  /// [0, count). @param count below 2^32.
  std::uint64_t below(std::uint64_t count) { return ((next() >> 32) * count) >> 32; }

  /// Mean 0, variance 1; a sum of 64 signs, for use in sums of several.
  double nearlyNormal() {
    std::uint64_t x = next();
    x -= (x >> 1) & 0x5555555555555555ULL;
    x = (x & 0x3333333333333333ULL) + ((x >> 2) & 0x3333333333333333ULL);
    x = (x + (x >> 4)) & 0x0F0F0F0F0F0F0F0FULL;
    return (static_cast<double>((x * 0x0101010101010101ULL) >> 56) - 32.0) * 0.25;
  }

 private:
  std::uint64_t state_;
};

}  // namespace battery_sof
