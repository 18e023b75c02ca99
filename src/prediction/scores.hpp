#pragma once

#include <optional>
#include <vector>

#include "battery_sof/series.hpp"
#include "estimation/fit_quality.hpp"
#include "prediction/profile.hpp"
#include "recording/events.hpp"

namespace battery_sof {

/// One crank's lowest voltage, measured and predicted.
struct CrankScore {
  double time = 0.0;              ///< [s], of the measured minimum
  double current = 0.0;           ///< [A], of largest magnitude
  double measured_minimum = 0.0;  ///< [V]
  Interval predicted_minimum;     ///< [V], each bound's own minimum over the crank
};

/// How a prediction compares with what was measured.
struct PredictionScores {
  FitWindow window;
  std::optional<double> q_dyn_percent;
  double rmse = 0.0;         ///< [V]
  double max_abs = 0.0;      ///< [V]
  double coverage_90 = 0.0;  ///< share of samples inside their 90 % interval [0, 1]
  std::vector<CrankScore> cranks;
  std::optional<double> crank_mean_abs_error;  ///< [V]; none without cranks
};

/// @param range, predicted as given to and returned by predictSeries().
PredictionScores scorePrediction(const Series& series, IndexRange range,
                                 const PredictedVoltage& predicted, const EventLimits& limits = {});

}  // namespace battery_sof
