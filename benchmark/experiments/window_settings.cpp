#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "estimation/identification.hpp"
#include "experiment.hpp"
#include "prediction/scores.hpp"

namespace battery_sof {
namespace {

/// Where a window opens.
enum class StartRule {
  kAsItFalls,  ///< at the paper's minute marks
  kOnEdge,     ///< at the first sample inside a current edge, at most 5 s later
  kQuiet,      ///< at the first sample half a second from any edge, at most 5 s later
};

/// One way to identify; against "paper" and "default" each changes one factor.
struct Setting {
  std::string name;
  IdentifyOptions options;
  StartRule start_rule = StartRule::kAsItFalls;
  /// search starts at the default procedure's parameters: detects a local minimum
  bool from_optimum = false;
};

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

std::vector<Setting> settings() {
  IdentifyOptions paper;
  paper.start = FitStart::kPaper;
  std::vector<Setting> all{{"paper", paper},
                           {"paper, start on an edge", paper, StartRule::kOnEdge},
                           {"paper, quiet start", paper, StartRule::kQuiet},
                           {"paper, 200 iterations", paper},
                           {"paper, W = 1", paper},
                           {"paper, from the optimum", paper, StartRule::kAsItFalls, true},
                           {"default", {}},
                           {"default, start on an edge", {}, StartRule::kOnEdge}};
  all[3].options.max_iterations = 200;
  all[4].options.crank_weight = 1.0;
  for (const double weight : {1.0, 3.0, 5.0, 20.0}) {
    all.push_back({"default, W = " + std::to_string(static_cast<int>(weight)), {}});
    all.back().options.crank_weight = weight;
  }
  all.push_back({"with S1 and S3", {}});
  all.back().options.effects = {"cpe2", "current_dependent_resistance"};
  return all;
}

/// @return starts of the paper's windows [1-5, 6.5-10.5, ...] min that fit into the recording [s].
std::vector<double> paperWindowStarts(const Series& series) {
  std::vector<double> starts;
  for (double from = series.time.front() + 60.0; from + kWindowLength <= series.time.back() + 0.1;
       from += kWindowShift)
    starts.push_back(from);
  return starts;
}

/// A window's fit, and how it predicts the whole recording.
struct WindowResult {
  FittedModel model;
  PredictionScores hour;
  std::vector<double> crank_errors;  ///< |measured - predicted minimum| of each pulse [V]
};

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

void printRow(const std::string& recording, const std::string& setting, int window,
              const WindowResult& r) {
  const auto& errors = r.crank_errors;
  const double count = std::max<double>(static_cast<double>(errors.size()), 1.0);
  const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / count;
  double square = 0.0;
  for (double e : errors) square += (e - mean) * (e - mean) / count;
  const auto& p = r.model.fit.parameters;
  std::printf("%s,\"%s\",%d,%.2f,%.3f,%.3f,%.5f,%.5f,%d,%d,%s,%.6f,%.6f,%.3f,%.4f,%.4f\n",
              recording.c_str(), setting.c_str(), window, r.model.fit.window.from,
              r.model.fit.scores.q_dyn_percent, r.hour.q_dyn_percent.value_or(NAN), mean,
              std::sqrt(square), r.model.fit.scores.cranks, r.model.fit.iterations,
              toString(r.model.fit.status).c_str(), p.r_discharge, p.r_charge, p.c2, p.beta,
              p.u_dc);
}

}  // namespace

void fitUnderSettings(const Recording& recording, const ExperimentOptions&) {
  const auto starts = paperWindowStarts(recording.series);
  for (const auto& setting : settings())
    for (std::size_t k = 0; k < starts.size(); ++k)
      printRow(recording.name, setting.name, static_cast<int>(k) + 1,
               runWindow(recording.series, starts[k], setting));
}

}  // namespace battery_sof
