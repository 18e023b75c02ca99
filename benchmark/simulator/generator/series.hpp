#pragma once

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace battery_sof_simulator {

/// A series between two entries by a straight line; the ends are held. @param position in entries.
inline double valueAt(const std::vector<double>& series, double position) {
  const double inside = std::clamp(position, 0.0, static_cast<double>(series.size() - 1));
  const auto before = static_cast<std::size_t>(inside);
  const std::size_t after = std::min(before + 1, series.size() - 1);
  return series[before] + (inside - static_cast<double>(before)) * (series[after] - series[before]);
}

/// The value that a share of all lie below; 0 of none.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

/// Knots joined by straight lines, per_knot entries apart.
inline std::vector<double> joined(const std::vector<double>& knots, std::size_t per_knot) {
  std::vector<double> line((knots.size() - 1) * per_knot + 1);
  for (std::size_t n = 0; n < line.size(); ++n) {
    const std::size_t k = n / per_knot, next = std::min(k + 1, knots.size() - 1);
    const double share = static_cast<double>(n % per_knot) / static_cast<double>(per_knot);
    line[n] = knots[k] + share * (knots[next] - knots[k]);
  }
  return line;
}

/// A current as a recording's samples know it: means around each sample, linear between. What a
/// recording of these samples leaves unknown between them is then nothing.
/// @param per_sample entries of `current` a sample, >= 1.
inline std::vector<double> linearBetweenSamples(const std::vector<double>& current,
                                                std::size_t per_sample) {
  if (per_sample < 1) throw std::invalid_argument("per_sample is 0, expected 1 or more");
  std::vector<double> knots((current.size() - 1) / per_sample + 1, 0.0);
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const std::size_t middle = k * per_sample, reach = per_sample / 2;
    const std::size_t from = middle > reach ? middle - reach : 0;
    const std::size_t to = std::min(middle + reach, current.size() - 1);
    for (std::size_t n = from; n <= to; ++n) knots[k] += current[n];
    knots[k] /= static_cast<double>(to - from + 1);
  }
  knots[0] = current[0];  // a battery begins at rest
  return joined(knots, per_sample);
}

}  // namespace battery_sof_simulator
