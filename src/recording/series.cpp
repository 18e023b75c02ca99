#include "battery_sof/series.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "recording/channel_statistics.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

std::size_t firstNotBefore(const std::vector<double>& time, double instant) {
  return std::lower_bound(time.begin(), time.end(), instant) - time.begin();
}

std::vector<double> copyRange(const std::vector<double>& values, IndexRange range) {
  return {values.begin() + range.first, values.begin() + range.last};
}

IndexRange rangeBetween(const std::vector<double>& time, double from, double to) {
  const std::size_t first = firstNotBefore(time, from);
  const auto behind = std::upper_bound(time.begin(), time.end(), to) - time.begin();
  return {first, std::max(first, static_cast<std::size_t>(behind))};
}

/// Median of some of the intervals, evenly spread; n of them are there.
double probedInterval(const double* time, std::size_t n) {
  std::vector<double> probes(std::min<std::size_t>(n, 255));
  for (std::size_t k = 0; k < probes.size(); ++k) {
    const std::size_t at = k * n / probes.size();
    probes[k] = time[at + 1] - time[at];
  }
  return quantile(std::move(probes), 0.5);
}

/// Whether so many of n intervals equal a value that it is their median: what evenly sampled
/// recordings have.
bool isMedian(double value, const double* time, std::size_t n) {
  std::size_t below = 0, above = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double interval = time[k + 1] - time[k];
    below += interval < value ? 1 : 0;
    above += interval > value ? 1 : 0;
  }
  return 2 * below < n && 2 * above < n;
}

}  // namespace

void requireInvariants(const Series& series) {
  const std::size_t n = series.size();
  if (series.current.size() != n || series.voltage.size() != n)
    throw std::invalid_argument(
        format("series: %zu times, %zu currents and %zu voltages, expected as many of each", n,
               series.current.size(), series.voltage.size()));
  for (std::size_t k = 0; k < n; ++k) {
    const Sample at = series[k];
    for (const auto& [name, value] :
         {std::pair{"time", at.time}, {"current", at.current}, {"voltage", at.voltage}})
      if (!std::isfinite(value))
        throw std::invalid_argument(
            format("series: %s of sample %zu is %g, expected a finite number", name, k, value));
    if (k > 0 && !(at.time > series.time[k - 1]))
      throw std::invalid_argument(
          format("series: time of sample %zu is %.17g s, expected more than the %.17g s before it",
                 k, at.time, series.time[k - 1]));
  }
}

double medianInterval(const Series& series) {
  return medianInterval(series.time, {0, series.size()});
}

double medianInterval(const std::vector<double>& time, IndexRange range) {
  if (range.size() < 2) return 0.0;
  const double probed = probedInterval(time.data() + range.first, range.size() - 1);
  if (isMedian(probed, time.data() + range.first, range.size() - 1)) return probed;
  const auto first = time.begin() + range.first, last = time.begin() + range.last;
  std::vector<double> interval(range.size() - 1);
  std::transform(first + 1, last, first, interval.begin(),
                 [](double later, double earlier) { return later - earlier; });
  return medianOf(std::move(interval));
}

double gapThreshold(const Series& series) { return gapThreshold(medianInterval(series)); }

double gapThreshold(double median_interval) { return std::max(10.0 * median_interval, 5.0); }

std::vector<IndexRange> contiguousRanges(const Series& series, double max_gap) {
  const auto joined = [&](std::size_t k) { return series.time[k] - series.time[k - 1] <= max_gap; };
  return cutWhere({0, series.size()}, joined);
}

IndexRange indexRange(const Series& series, double from, double to) {
  return rangeBetween(series.time, from, to);
}

std::size_t firstAfter(const Series& series, double time) {
  return std::upper_bound(series.time.begin(), series.time.end(), time) - series.time.begin();
}

Series slice(const Series& series, IndexRange range) {
  Series part;
  if (range.empty()) return part;
  part.time = copyRange(series.time, range);
  part.current = copyRange(series.current, range);
  part.voltage = copyRange(series.voltage, range);
  const IndexRange warm =
      rangeBetween(series.temperature_time, part.time.front(), part.time.back());
  part.temperature_time = copyRange(series.temperature_time, warm);
  part.temperature = copyRange(series.temperature, warm);
  return part;
}

std::optional<double> temperatureAt(const Series& series, double time) {
  if (series.temperature.empty()) return std::nullopt;
  const std::size_t next = firstNotBefore(series.temperature_time, time);
  if (next == 0) return series.temperature.front();
  if (next == series.temperature.size()) return series.temperature.back();
  const double t0 = series.temperature_time[next - 1], t1 = series.temperature_time[next];
  const double weight = (time - t0) / (t1 - t0);
  return (1.0 - weight) * series.temperature[next - 1] + weight * series.temperature[next];
}

}  // namespace battery_sof
