#include "recording/current_flicker.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "recording/channel_statistics.hpp"

namespace battery_sof {
namespace {

constexpr double kSlowest = 0.105;  // [s] between samples
constexpr double kLongest = 0.5;    // [s] to either side
constexpr double kKept = 0.75;      // of the second differences; the others may be edges
// mean square of the smaller three quarters of a standard normal
constexpr double kKeptVariance = 0.3684;
// of the noise's variance: what a window may depart from its quadratic
constexpr double kQuiet = 1.6;
constexpr double kStep = 10.0;  // [A], over three samples: a step that shows r
constexpr std::size_t kStepSamples = 3;

/// Standard deviation of white noise on a course that is smooth over three samples: from the
/// smaller three quarters of its second differences. Their mean square, not their median: values
/// may be coarse.
double noiseOf(const std::vector<double>& x) {
  if (x.size() < 12) return 0.0;
  std::vector<double> squares;
  for (std::size_t k = 1; k + 1 < x.size(); ++k) {
    const double difference = x[k - 1] - 2.0 * x[k] + x[k + 1];
    squares.push_back(difference * difference);
  }
  const auto end =
      squares.begin() + static_cast<std::ptrdiff_t>(kKept * static_cast<double>(squares.size()));
  std::nth_element(squares.begin(), end, squares.end());
  const double mean =
      std::accumulate(squares.begin(), end, 0.0) / static_cast<double>(end - squares.begin());
  return std::sqrt(mean / (kKeptVariance * 6.0));
}

/// Samples -before to after around one.
struct Window {
  int before, after;
  Eigen::Matrix3d inverse;  // of the normal equations of a quadratic over them
};

Window windowOf(int before, int after) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (int j = -before; j <= after; ++j) {
    const Eigen::Vector3d powers(1.0, j, static_cast<double>(j) * j);
    normal += powers * powers.transpose();
  }
  return {before, after, normal.inverse()};
}

/// Value at sample 0 of a quadratic over a window, and what the samples depart from it.
struct Local {
  double value, variance;
};
Local quadratic(const double* at, const Window& window) {
  double sum = 0.0, first = 0.0, second = 0.0, squares = 0.0;
  for (int j = -window.before; j <= window.after; ++j) {
    const double x = j, y = at[j] - at[0];
    sum += y;
    first += x * y;
    second += x * x * y;
    squares += y * y;
  }
  const Eigen::Vector3d right(sum, first, second), c = window.inverse * right;
  return {at[0] + c[0], std::max(0.0, squares - c.dot(right)) /
                            std::max(1.0, window.before + window.after - 2.0)};
}

/// The windows that are tried, the least noisy first: to both sides, and to one where an edge lies
/// on the other.
std::vector<Window> windowsOf(double interval) {
  std::vector<Window> windows;
  for (int h = static_cast<int>(std::lround(kLongest / interval)); h >= 3; h = h * 2 / 3)
    windows.push_back(windowOf(h, h));
  for (int h = static_cast<int>(std::lround(kLongest / interval)); h >= 8; h = h * 2 / 3) {
    windows.push_back(windowOf(0, h));
    windows.push_back(windowOf(h, 0));
  }
  // Variance of the value: 9/4 of the noise's over the samples in the middle, 9 at an end.
  std::stable_sort(windows.begin(), windows.end(), [](const Window& a, const Window& b) {
    const auto noise = [](const Window& w) {
      return (w.before == w.after ? 2.25 : 9.0) / (w.before + w.after + 1.0);
    };
    return noise(a) < noise(b);
  });
  return windows;
}

}  // namespace

CurrentFlicker currentFlicker(const Series& series) {
  CurrentFlicker flicker{series.current, 1.0};
  const double interval = medianInterval(series);
  if (!(interval > 0.0) || interval > kSlowest) return flicker;
  const double noise = noiseOf(series.current);
  const double resistance = changeSums(series, kStepSamples, [](std::size_t, double di) {
                              return !(std::abs(di) < kStep);
                            }).slope();
  if (!(noise > 0.0)) return flicker;
  const std::vector<Window> windows = windowsOf(interval);
  double products = 0.0, squares = 0.0;
  for (const IndexRange& range : contiguousRanges(series, 3.0 * interval))
    for (std::size_t k = range.first; k < range.last; ++k)
      for (const Window& window : windows) {
        if (k < range.first + static_cast<std::size_t>(window.before) ||
            k + static_cast<std::size_t>(window.after) >= range.last)
          continue;
        const Local local = quadratic(&series.current[k], window);
        if (local.variance > kQuiet * noise * noise) continue;
        flicker.smooth[k] = local.value;
        const double own = series.current[k] - local.value;
        products += own * (series.voltage[k] - quadratic(&series.voltage[k], window).value);
        squares += own * own;
        break;
      }
  if (!(resistance > 0.0) || !(squares > 0.0)) return flicker;
  flicker.share = std::clamp(products / squares / resistance, 0.0, 1.0);
  return flicker;
}

Series withoutSensorNoise(const Series& series, const CurrentFlicker& flicker) {
  Series quiet = series;
  for (std::size_t k = 0; k < quiet.size(); ++k)
    quiet.current[k] = flicker.smooth[k] + flicker.share * (series.current[k] - flicker.smooth[k]);
  return quiet;
}

}  // namespace battery_sof
