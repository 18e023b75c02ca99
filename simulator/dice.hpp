#pragma once

#include <cstdint>
#include <random>

namespace battery_sof_simulator {

/// Lowest and highest value of something drawn at random.
struct Range {
  double low, high;
};

/// Seeded random numbers; the same seed and stream give the same numbers.
class Dice {
 public:
  /// @param stream separates numbers of different purposes, so that more of one leaves the others
  /// as they are.
  Dice(std::uint64_t seed, std::uint32_t stream);

  /// Numbers of one purpose alone.
  explicit Dice(std::uint64_t seed) : engine_(seed) {}

  double share();  ///< uniform in [0, 1)
  double between(const Range& range);
  double logBetween(const Range& range);  ///< uniform in the logarithm; both ends above 0
  double sign();                          ///< -1 or 1
  double normal();                        ///< mean 0, standard deviation 1

  /**
   * @brief A number of the range, leaning to one end: low + (high - low) x^(2^lean), x uniform.
   * @param lean 0 uniform, positive towards low, negative towards high; limited to 4 on either
   * side.
   */
  double leaning(const Range& range, double lean);

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_{0.0, 1.0};
};

}  // namespace battery_sof_simulator
