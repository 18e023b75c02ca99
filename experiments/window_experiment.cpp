#include "window_experiment.hpp"

#include <algorithm>
#include <cmath>

#include "estimation/identification.hpp"
#include "prediction/scores.hpp"

namespace battery_sof::experiments {
namespace {

constexpr double kWindowLength = 240.0;  // [s], paper, section V
constexpr double kWindowShift = 330.0;   // [s], paper, Fig. 5
constexpr double kReach = 5.0;           // [s], how far a window's start may be moved
constexpr double kEdge = 5.0;            // [A] between neighbouring samples

IndexRange windowFrom(const Series& series, double from) {
  return indexRange(series, from, from + kWindowLength);
}

/// Largest change of current within half a second around a sample [A].
double unrest(const Series& series, std::size_t n) {
  double largest = 0.0;
  for (std::size_t k = std::max<std::size_t>(n, 51) - 50; k < std::min(n + 50, series.size()); ++k)
    largest = std::max(largest, std::abs(series.current[k] - series.current[k - 1]));
  return largest;
}

/// The first sample from `from` on, at most kReach later, that lies inside an edge, or far from
/// any.
double movedStart(const Series& series, double from, bool onto_edge) {
  const IndexRange reach = indexRange(series, from, from + kReach);
  for (std::size_t n = std::max<std::size_t>(reach.first, 1); n < reach.last; ++n) {
    const double step = std::abs(series.current[n] - series.current[n - 1]);
    if (onto_edge ? step > kEdge : unrest(series, n) < 0.5) return series.time[n];
  }
  return from;
}

IdentifyOptions paperOptions() {
  IdentifyOptions options;
  options.start = FitStart::kPaper;
  return options;
}

}  // namespace

std::vector<Setting> settings() {
  std::vector<Setting> all;
  all.push_back({"paper", "the paper's procedure", paperOptions(), StartRule::kAsItFalls, false});
  all.push_back({"paper, start on an edge", "window opens inside a current edge", paperOptions(),
                 StartRule::kOnEdge, false});
  all.push_back({"paper, quiet start", "window opens half a second from any edge", paperOptions(),
                 StartRule::kQuiet, false});
  all.push_back({"paper, 200 iterations", "iteration limit lifted", paperOptions(),
                 StartRule::kAsItFalls, false});
  all.back().options.max_iterations = 200;
  all.push_back(
      {"paper, W = 1", "no extra weight on pulses", paperOptions(), StartRule::kAsItFalls, false});
  all.back().options.crank_weight = 1.0;
  all.push_back({"paper, from the optimum", "search starts at the default procedure's result",
                 paperOptions(), StartRule::kAsItFalls, true});
  all.push_back({"default", "this package's procedure", {}, StartRule::kAsItFalls, false});
  all.push_back({"default, start on an edge",
                 "window opens inside a current edge",
                 {},
                 StartRule::kOnEdge,
                 false});
  all.push_back({"default, W = 1", "no extra weight on pulses", {}, StartRule::kAsItFalls, false});
  all.back().options.crank_weight = 1.0;
  for (const double weight : {3.0, 5.0, 20.0}) {
    all.push_back({"default, W = " + std::to_string(static_cast<int>(weight)),
                   "another weight on pulses",
                   {},
                   StartRule::kAsItFalls,
                   false});
    all.back().options.crank_weight = weight;
  }
  all.push_back(
      {"with S1 and S3",
       "a fractional double layer and a resistance that falls with current are fitted too",
       {},
       StartRule::kAsItFalls,
       false});
  all.back().options.effects = {"cpe2", "current_dependent_resistance"};
  return all;
}

std::vector<double> paperWindowStarts(const Series& series) {
  std::vector<double> starts;
  for (double from = series.time.front() + 60.0; from + kWindowLength <= series.time.back() + 0.1;
       from += kWindowShift)
    starts.push_back(from);
  return starts;
}

WindowResult runWindow(const Series& series, double from, const Setting& setting) {
  if (setting.start_rule != StartRule::kAsItFalls)
    from = movedStart(series, from, setting.start_rule == StartRule::kOnEdge);
  const IndexRange window = windowFrom(series, from);
  IdentifyOptions options = setting.options;
  if (setting.from_optimum) {
    const BaseParameters optimum = identify(series, window).fit.parameters;
    options.initial = {optimum.r_discharge, optimum.r_charge, optimum.c2, optimum.beta};
  }
  WindowResult result;
  result.model = identify(series, window, options);
  const IndexRange whole{0, series.size()};
  result.hour =
      scorePrediction(series, whole, predictSeries(result.model, series, whole).voltages());
  for (const auto& crank : result.hour.cranks)
    result.crank_errors.push_back(std::abs(crank.measured - crank.expected.value));
  return result;
}

}  // namespace battery_sof::experiments
