#include "estimation/window.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/base_normal_equations.hpp"
#include "recording/events.hpp"
#include "recording/moved_charge.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kPaperWindow = 240.0;  // [s], paper, section V
constexpr double kSamplesAtSlowRates = 900.0;
constexpr double kAssumedError = 0.010;      // [V], see windowExcitation()
constexpr double kAssumedCorrelation = 5.0;  // [s]
// relative standard error that halves a parameter's share
constexpr double kEnough = 0.05;
// share of a parameter that the window says nothing about
constexpr double kNotExcited = 1e-3;
// of the best window quality: then the later window wins
constexpr double kNearlyBest = 0.95;
constexpr int kHopsPerWindow = 8;

/// Information that a window's current carries on (linear parameters, ln c2, ln beta, first state).
using Information = Eigen::Matrix<double, 6, 6>;

Information informationOf(const WindowSamples& samples) {
  // Averages of ten keep the information to a few per cent at a tenth of the cost; slow recordings
  // are taken as they are.
  const std::size_t factor = samples.size() >= 4000 ? 10 : 1;
  auto averages = coarsened(samples, factor);
  for (std::size_t k = 0; k < averages.size(); ++k)
    averages[k].weight = static_cast<double>(std::min(factor, samples.size() - k * factor));
  const BaseParameters nominal;
  const BaseNormalEquations equations(averages, nominal.i0);
  return equations.sums({nominal.c2, nominal.beta, 0.0}).topLeftCorner<6, 6>();
}

/// Relative standard errors of r_discharge, r_charge, c2, beta; infinite where nothing is known.
std::array<double, 4> relativeErrors(const Information& info, double variance) {
  const Eigen::Matrix<double, 6, 1> scale =
      info.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
  const Information scaled = scale.asDiagonal() * info * scale.asDiagonal();
  const Information inverse =
      (scaled + 1e-14 * Information::Identity()).ldlt().solve(Information::Identity());
  const std::array<int, 4> row = {kColumnDischarge, kColumnCharge, kColumnLogC2, kColumnLogBeta};
  const std::array<double, 4> magnitude = {tableOne()[0].magnitude, tableOne()[1].magnitude, 1.0,
                                           1.0};
  std::array<double, 4> relative;
  for (int j = 0; j < 4; ++j) {
    const double s = scale[row[j]];
    relative[j] =
        s > 0.0 ? s * std::sqrt(std::max(inverse(row[j], row[j]), 0.0) * variance) / magnitude[j]
                : std::numeric_limits<double>::infinity();
  }
  return relative;
}

/// All windows of the wanted length inside one stretch without gaps, an eighth of a window apart.
void appendWindows(const Series& series, IndexRange stretch, double length,
                   std::vector<IndexRange>& windows) {
  const double begin = series.time[stretch.first];
  const double end = series.time[stretch.last - 1];
  if (end - begin < length) return;
  const int hops = static_cast<int>((end - begin - length) / (length / kHopsPerWindow));
  for (int k = 0; k <= hops; ++k) {
    // Counted from the end, so that the latest window reaches the latest sample.
    const double to = end - k * length / kHopsPerWindow;
    windows.push_back(indexRange(series, to - length, to));
  }
  // So that the first sample is in one, too.
  windows.push_back(indexRange(series, begin, begin + length));
}

std::vector<IndexRange> candidates(const Series& series, IndexRange searched, double length) {
  const Series part = slice(series, searched);
  std::vector<IndexRange> stretches = contiguousRanges(part, gapThreshold(series));
  std::vector<IndexRange> windows;
  for (auto& stretch : stretches) {
    stretch.first += searched.first;
    stretch.last += searched.first;
    appendWindows(series, stretch, length, windows);
  }
  if (windows.empty()) windows = stretches;  // nothing is as long as wanted: whole stretches then
  return windows;
}

/// Whether a window draws enough for a model of it to answer for the largest discharge of what was
/// searched.
std::vector<char> reaching(const Series& series, IndexRange searched,
                           const std::vector<IndexRange>& windows) {
  const auto lowestOf = [&](IndexRange range) {
    return *std::min_element(series.current.begin() + range.first,
                             series.current.begin() + range.last);
  };
  const double enough = std::min(0.0, lowestOf(searched)) / kCurrentReach;
  std::vector<char> reaches;
  for (const IndexRange window : windows) reaches.push_back(lowestOf(window) <= enough);
  return reaches;
}

}  // namespace

double defaultWindowLength(const Series& series) {
  return std::max(kPaperWindow, kSamplesAtSlowRates * medianInterval(series));
}

double windowExcitation(const Series& series, IndexRange range) {
  const std::vector<char> none;
  return windowExcitation(WindowSamples{series, range, {}, gapThreshold(series), none});
}

double windowExcitation(const WindowSamples& samples) {
  if (samples.size() < kMinFitSamples) return 0.0;
  const double interval = samples.duration() / static_cast<double>(samples.size());
  const double inflation = std::max(1.0, 2.0 * kAssumedCorrelation / interval);
  double product = 1.0;
  for (double relative :
       relativeErrors(informationOf(samples), kAssumedError * kAssumedError * inflation))
    product *= std::max(kEnough / (kEnough + relative), kNotExcited);
  return std::pow(product, 0.25);
}

WindowChoice chooseWindow(const Series& series, IndexRange searched, std::optional<double> length) {
  WindowChoice choice;
  if (searched.size() < kMinFitSamples) {
    choice.message =
        format("no window: the searched stretch has %zu samples, but at least %zu are needed",
               searched.size(), kMinFitSamples);
    return choice;
  }
  const std::vector<IndexRange> windows =
      candidates(series, searched, length.value_or(defaultWindowLength(series)));
  std::vector<double> window_quality;
  for (const IndexRange window : windows)
    window_quality.push_back(windowExcitation(series, window));
  double best = *std::max_element(window_quality.begin(), window_quality.end());
  const std::vector<char> reaches = reaching(series, searched, windows);
  double best_reaching = 0.0;
  for (std::size_t k = 0; k < windows.size(); ++k)
    if (reaches[k]) best_reaching = std::max(best_reaching, window_quality[k]);
  // The largest discharge is worth as much as one parameter that is not excited costs.
  const bool must_reach = best_reaching >= std::pow(kNotExcited, 0.25) * best;
  if (must_reach) best = best_reaching;
  for (std::size_t k = 0; best > 0.0 && k < windows.size(); ++k) {
    if (window_quality[k] < kNearlyBest * best || (must_reach && !reaches[k])) continue;
    if (choice.range && windows[k].last < choice.range->last) continue;
    choice.range = windows[k];
    choice.excitation = window_quality[k];
  }
  choice.message = "no window: the current never changes";
  if (choice.range)
    choice.message = format("window %g to %g s, %zu samples, window quality %g",
                            series.time[choice.range->first], series.time[choice.range->last - 1],
                            choice.range->size(), choice.excitation);
  return choice;
}

double windowQuality(double rmse, double excitation) {
  constexpr double kIntercept = -1.683, kRmse = 1.018, kExcitation = -7.88;  // see header
  // below it no window was seen: the power law is not trusted
  constexpr double kMinExcitation = 0.4;
  // [V], error at which s is one half
  constexpr double kHalf = 0.05;
  if (!(rmse > 0.0)) return excitation > 0.0 ? 1.0 : 0.0;
  const double error =
      std::exp(kIntercept + kRmse * std::log(rmse) +
               kExcitation * std::log(std::max(excitation, kMinExcitation) + 0.02));
  return 1.0 / (1.0 + error / kHalf);
}

namespace {

// [A], where a run of one direction ends
constexpr double kRest = EventLimits::kRestCurrent;

/// Where a run ends that flows at sample n. @param sign 1 charging, -1 discharging.
std::size_t endOfRun(const Series& series, std::size_t n, std::size_t last, double sign,
                     double max_gap) {
  for (++n; n < last; ++n)
    if (!(sign * series.current[n] > kRest) || series.time[n] - series.time[n - 1] > max_gap) break;
  return n;
}

/// How long current flowed either way, run by run.
void addFlowTimes(const Series& series, IndexRange range, double max_gap, ExcitedRange& excited) {
  for (std::size_t n = range.first + 1, next; n < range.last; n = next) {
    next = n + 1;
    const double i = series.current[n];
    if (i == 0.0 || series.time[n] - series.time[n - 1] > max_gap) continue;
    const bool runs = std::abs(i) > kRest;
    if (runs) next = endOfRun(series, n, range.last, i > 0.0 ? 1.0 : -1.0, max_gap);
    const double time = series.time[next - 1] - series.time[n - 1];
    (i > 0.0 ? excited.charge_time : excited.discharge_time) += time;
    double& longest = i > 0.0 ? excited.longest_charge : excited.longest_discharge;
    if (runs) longest = std::max(longest, time);
  }
}

}  // namespace

ExcitedRange excitedRange(const Series& series, IndexRange range, std::optional<double> max_gap) {
  ExcitedRange excited;
  if (range.empty()) return excited;
  if (!max_gap) max_gap = gapThreshold(series);
  const auto values = [&](const std::vector<double>& all) {
    return Eigen::Map<const Eigen::ArrayXd>(all.data() + range.first, range.size());
  };
  excited.min_current = values(series.current).minCoeff();
  excited.max_current = values(series.current).maxCoeff();
  excited.min_voltage = values(series.voltage).minCoeff();
  excited.max_voltage = values(series.voltage).maxCoeff();
  addFlowTimes(series, range, *max_gap, excited);
  excited.charge_swing = movedCharge(series, range, *max_gap).span;
  excited.temperature =
      temperatureAt(series, 0.5 * (series.time[range.first] + series.time[range.last - 1]));
  return excited;
}

}  // namespace battery_sof
