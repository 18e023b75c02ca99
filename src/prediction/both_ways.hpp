#pragma once

#include <optional>
#include <vector>

#include "prediction/mixed_scores.hpp"
#include "prediction/profile.hpp"
#include "prediction/scores.hpp"

namespace battery_sof {

/// How a predictor did in the direction that was controlled, sample by sample and event by event.
struct BothWaysScores {
  MixedScores mixed;
  std::vector<CrankScore> cranks;
  std::optional<double> crank_mean_abs_error;  ///< [V]; none without cranks
};

/**
 * @brief Scores a model that followed a range: samples as predicted, cranks and charges as a query
 * answers them, compared with the cranks and charges of the model's window
 * (correctCrankPrediction(), correctChargePrediction()).
 */
BothWaysScores scoreBothWays(const FittedModel& model, const Series& series, IndexRange range,
                             const FollowedPrediction& predicted);

/// The same of the baseline predictors of a model's window. @param voltage_controlled one a sample
/// of the range.
BothWaysScores scoreBaseline(const BaselinePredictor& baseline, const Series& series,
                             IndexRange range, const std::vector<char>& voltage_controlled);

/// @return the baseline line's voltage from the current alone, over the whole range; empty without
/// a line.
PredictedVoltage baselineVoltage(const BaselinePredictor& baseline, const Series& series,
                                 IndexRange range);

}  // namespace battery_sof
