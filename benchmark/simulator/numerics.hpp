#pragma once

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace battery_sof_simulator {

inline constexpr double kPi = 3.14159265358979323846, kTwoPi = 2.0 * kPi;
inline constexpr double kSecondsPerHour = 3600.0, kSecondsPerMinute = 60.0;

/// A law at one point and its derivative there.
struct Linearised {
  double value, slope;
};

/// Equations without a solution, e.g. a charge that nothing can take up.
class NoSolution : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Root of an increasing function by Newton's method, kept between points of known sign.
/// @param function  callable: double -> Linearised {value, slope}, slope > 0.
/// @param guess     start, finite.
/// @param tolerance of |value|, > 0.
/// @throws NoSolution after 200 steps without reaching it, as of a function that does not increase.
template <typename Function>
double increasingRoot(const Function& function, double guess, double tolerance) {
  double low = -std::numeric_limits<double>::infinity();
  double high = -low;
  double x = guess;
  for (int iteration = 0; iteration < 200; ++iteration) {
    const Linearised at = function(x);
    if (std::abs(at.value) <= tolerance) return x;
    (at.value < 0.0 ? low : high) = x;
    const double newton = x - at.value / at.slope;
    const bool inside = newton > low && newton < high;
    const double middle =
        std::isfinite(low + high) ? 0.5 * (low + high) : 0.5 * x + (low == x ? 1.0 : -1.0);
    const double next = inside ? newton : middle;
    if (next == x) return x;
    x = next;
  }
  throw NoSolution("the battery's equations have no solution near " + std::to_string(guess));
}

}  // namespace battery_sof_simulator
