#include "battery_sof/recording/series.hpp"

#include <algorithm>

namespace battery_sof {
namespace {

std::size_t firstNotBefore(const std::vector<double>& time, double instant) {
  return std::lower_bound(time.begin(), time.end(), instant) - time.begin();
}

std::size_t firstAfter(const std::vector<double>& time, double instant) {
  return std::upper_bound(time.begin(), time.end(), instant) - time.begin();
}

std::vector<double> copyRange(const std::vector<double>& values, IndexRange range) {
  return {values.begin() + range.first, values.begin() + range.last};
}

IndexRange rangeBetween(const std::vector<double>& time, double from, double to) {
  const std::size_t first = firstNotBefore(time, from);
  return {first, std::max(first, firstAfter(time, to))};
}

}  // namespace

double medianInterval(const Series& series) {
  if (series.size() < 2) return 0.0;
  std::vector<double> interval(series.size() - 1);
  std::transform(series.time.begin() + 1, series.time.end(), series.time.begin(), interval.begin(),
                 [](double later, double earlier) { return later - earlier; });
  const auto middle = interval.begin() + interval.size() / 2;
  std::nth_element(interval.begin(), middle, interval.end());
  if (interval.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(interval.begin(), middle));
}

double gapThreshold(const Series& series) { return std::max(10.0 * medianInterval(series), 5.0); }

std::vector<IndexRange> contiguousRanges(const Series& series, double max_gap) {
  std::vector<IndexRange> ranges;
  std::size_t first = 0;
  for (std::size_t k = 1; k <= series.size(); ++k) {
    if (k < series.size() && series.time[k] - series.time[k - 1] <= max_gap) continue;
    ranges.push_back({first, k});
    first = k;
  }
  return ranges;
}

IndexRange indexRange(const Series& series, double from, double to) {
  return rangeBetween(series.time, from, to);
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
