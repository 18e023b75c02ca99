#include "recording/voltage_repair.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "recording/channel_statistics.hpp"
#include "recording/events.hpp"

namespace battery_sof {
namespace {

constexpr double kApart = 0.25;         // [V]
constexpr double kNeighbours = 0.4;     // of the smaller step
constexpr double kQuietCurrent = 25.0;  // [A]
constexpr int kFirstLag = -2, kLastLag = 3;
constexpr double kMinChange = 2.0, kMaxChange = 40.0;  // [A]
constexpr double kMinCorrelation = 0.3;

/// Correlation of changes of current with those of voltage `lag` samples later; 0 where it is
/// negative.
double correlation(const Series& series, int lag) {
  const auto taken = [&](std::size_t k, double di) {
    return k >= 4 && k + 4 < series.size() && std::abs(di) > kMinChange &&
           std::abs(di) < kMaxChange;
  };
  const ChangeSums sums = changeSums(series, 1, taken, lag);
  if (!(sums.current > 0.0 && sums.voltage > 0.0)) return 0.0;
  return std::max(0.0, sums.product / std::sqrt(sums.current * sums.voltage));
}

std::size_t findLag(const Series& series) {
  std::vector<double> c;
  for (int lag = kFirstLag; lag <= kLastLag; ++lag) c.push_back(correlation(series, lag));
  const auto peak = std::max_element(c.begin(), c.end());
  if (*peak < kMinCorrelation) return 0;
  const auto first = peak == c.begin() ? peak : peak - 1;
  const auto last = peak + 1 == c.end() ? c.end() : peak + 2;
  double weights = 0.0, sum = 0.0;
  for (auto at = first; at != last; ++at) {
    const double weight = std::pow(*at, 2);
    weights += weight;
    sum += weight * static_cast<double>(at - c.begin() + kFirstLag);
  }
  return static_cast<std::size_t>(std::max(0.0, std::round(sum / weights)));
}

}  // namespace

bool isDropOut(const Series& series, std::size_t k) {
  if (k == 0 || k + 1 >= series.size()) return false;
  const double from = series.voltage[k] - series.voltage[k - 1],
               to = series.voltage[k] - series.voltage[k + 1];
  const double between = std::abs(series.voltage[k + 1] - series.voltage[k - 1]);
  const double neighbours = 0.5 * (series.current[k - 1] + series.current[k + 1]);
  return std::abs(from) > kApart && std::abs(to) > kApart && (from > 0.0) == (to > 0.0) &&
         between < kNeighbours * std::min(std::abs(from), std::abs(to)) &&
         series.current[k] > EventLimits{}.engineTurns() &&
         std::abs(series.current[k] - neighbours) < kQuietCurrent;
}

VoltageRepair findVoltageRepair(const Series& series) {
  VoltageRepair repair;
  for (std::size_t k = 0; k < series.size(); ++k) repair.dropped.push_back(isDropOut(series, k));
  repair.lag = findLag(repaired(series, repair));
  return repair;
}

Series repaired(const Series& series, const VoltageRepair& repair) {
  if (repair.dropped.size() != series.size())
    throw std::invalid_argument("repaired: marks for " + std::to_string(repair.dropped.size()) +
                                " samples of a recording of " + std::to_string(series.size()));
  Series out = series;
  for (std::size_t k = 1; k + 1 < series.size(); ++k)
    if (repair.dropped[k]) out.voltage[k] = 0.5 * (series.voltage[k - 1] + series.voltage[k + 1]);
  if (repair.lag == 0 || series.empty()) return out;
  const std::vector<double> behind = out.voltage;
  for (std::size_t k = 0; k < series.size(); ++k)
    out.voltage[k] = behind[std::min(k + repair.lag, series.size() - 1)];
  return out;
}

double repairedVoltage(const Series& series, std::size_t k, std::size_t lag) {
  const std::size_t shown = std::min(k + lag, series.size() - 1);
  return isDropOut(series, shown) ? 0.5 * (series.voltage[shown - 1] + series.voltage[shown + 1])
                                  : series.voltage[shown];
}

}  // namespace battery_sof
