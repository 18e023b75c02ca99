#include "recording/voltage_repair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "recording/events.hpp"

namespace battery_sof {
namespace {

constexpr double kApart = 0.25;         // [V]
constexpr double kNeighbours = 0.4;     // of the smaller step
constexpr double kQuietCurrent = 25.0;  // [A]
constexpr int kFirstLag = -2, kLastLag = 3;
constexpr double kMinChange = 2.0, kMaxChange = 40.0;  // [A]
constexpr double kMinCorrelation = 0.3;

/// Correlation of changes of current with those of voltage `lag` samples later.
double correlation(const Series& series, const std::vector<double>& voltage, int lag) {
  double both = 0.0, currents = 0.0, voltages = 0.0;
  for (std::size_t n = 4; n + 4 < series.size(); ++n) {
    const double di = series.current[n] - series.current[n - 1];
    if (!(std::abs(di) > kMinChange && std::abs(di) < kMaxChange)) continue;
    const auto m = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(n) + lag);
    const double du = voltage[m] - voltage[m - 1];
    both += di * du;
    currents += di * di;
    voltages += du * du;
  }
  return currents > 0.0 && voltages > 0.0 ? std::max(0.0, both / std::sqrt(currents * voltages))
                                          : 0.0;
}

std::size_t findLag(const Series& series, const std::vector<double>& voltage) {
  std::array<double, kLastLag - kFirstLag + 1> c;
  for (int lag = kFirstLag; lag <= kLastLag; ++lag)
    c[static_cast<std::size_t>(lag - kFirstLag)] = correlation(series, voltage, lag);
  const auto peak = std::max_element(c.begin(), c.end());
  if (*peak < kMinCorrelation) return 0;
  const auto at = static_cast<int>(peak - c.begin());
  double weights = 0.0, sum = 0.0;
  for (int k = std::max(0, at - 1); k <= std::min<int>(at + 1, static_cast<int>(c.size()) - 1);
       ++k) {
    const double weight = std::pow(c[static_cast<std::size_t>(k)], 2);
    weights += weight;
    sum += weight * (k + kFirstLag);
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
         series.current[k] > kEngineTurns &&
         std::abs(series.current[k] - neighbours) < kQuietCurrent;
}

VoltageRepair findVoltageRepair(const Series& series) {
  VoltageRepair repair;
  repair.dropped.assign(series.size(), 0);
  for (std::size_t k = 0; k < series.size(); ++k) repair.dropped[k] = isDropOut(series, k);
  const Series filled = repaired(series, repair);
  repair.lag = findLag(series, filled.voltage);
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
