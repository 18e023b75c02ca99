#pragma once

#include <string>
#include <vector>

#include "estimation/identification.hpp"
#include "prediction/scores.hpp"

/// Experiments on the paper's open question: why do look-alike windows predict so differently?
namespace battery_sof::experiments {

/// Where a window opens.
enum class StartRule {
  kAsItFalls,  ///< at the paper's minute marks
  kOnEdge,     ///< at the first sample inside a current edge, at most 5 s later
  kQuiet,      ///< at the first sample half a second from any edge, at most 5 s later
};

/// One way to identify; against "paper" and "default" each changes one factor.
struct Setting {
  std::string name;
  std::string what;
  IdentifyOptions options;
  StartRule start_rule = StartRule::kAsItFalls;
  /// search starts at the default procedure's parameters: detects a local minimum
  bool from_optimum = false;
};

std::vector<Setting> settings();

/// @return starts of the paper's windows [1-5, 6.5-10.5, ...] min that fit into the recording [s].
std::vector<double> paperWindowStarts(const Series& series);

/// A window's fit, and how it predicts the whole recording.
struct WindowResult {
  FittedModel model;
  PredictionScores hour;
  std::vector<double> crank_errors;  ///< |measured - predicted minimum| of each pulse [V]
};

WindowResult runWindow(const Series& series, double from, const Setting& setting);

}  // namespace battery_sof::experiments
