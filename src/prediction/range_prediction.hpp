#pragma once

#include <optional>
#include <stdexcept>

#include "prediction/both_ways.hpp"

namespace battery_sof {

/// The inputs of a model along a recording.
enum class PredictionMode {
  kAsFitted,  ///< both, where the model was fitted so; else the current
  kMixed,     ///< the voltage where a source controls it, else the current
  kCurrent,   ///< the current throughout
};

/// PredictionMode::kMixed was asked where no source is seen.
class NoSource : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Scores of a prediction in every operating mode, with those of the baseline.
struct PredictionReport {
  /// as the paper has it; its cranks are those of both_ways where that is
  PredictionScores from_current;
  std::optional<BothWaysScores> both_ways;  ///< none when the current is the input throughout
  BothWaysScores baseline;
  /// of the baseline line; none without one
  std::optional<PredictionScores> baseline_from_current;
};

/// A model's course through a range of a recording, and how well it did.
struct RangePrediction {
  FollowedPrediction course;  ///< one entry a sample of the range
  PredictionReport report;
};

/**
 * @brief Runs a model through a range of a recording and scores it.
 *
 * A model fitted without a source takes, for PredictionMode::kMixed, the one that is seen in the
 * series.
 * @param series at the rate to predict at, see atDesignRate().
 * @throws NoSource; the message says why none is seen.
 */
RangePrediction predictRange(FittedModel model, const Series& series, IndexRange range,
                             PredictionMode mode = PredictionMode::kAsFitted);

}  // namespace battery_sof
