#pragma once

#include <string>
#include <vector>

#include "baseline/baseline_predictor.hpp"
#include "battery_sof/series.hpp"
#include "prediction/event_corrections.hpp"
#include "prediction/pipeline.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/// Longest profile accepted [samples]: an hour at 1 kHz.
inline constexpr std::size_t kMaxProfileSamples = 3600000;

/**
 * @brief What the battery would answer to a current profile from the model's saved state on.
 *
 * @param time    [s] after the saved state, >= 0, each at least kShortestStep after the one before.
 * @param current [A], same length; linear between the samples, and from the state's own current to
 * the first sample.
 * @param watch   asked before every sample; broken off, the answer is kInvalidQuery and says how far it came.
 */
ProfileAnswer simulateProfile(const FittedModel& model, const std::vector<double>& time,
                              const std::vector<double>& current, const WorkWatch& watch = nullptr);

/// A prediction in the mixed direction with what a crank's correction starts from.
struct FollowedPrediction : MixedPrediction {
  /// one a sample of the range; the input is as measured and has no width
  std::vector<char> voltage_controlled;
  std::vector<double> equations_voltage;  ///< [V], of the equations alone
};

/// @return the model with the current as its input throughout: without source, lag of the voltage
/// and residual regression.
FittedModel drivenByCurrent(FittedModel model);

/**
 * @brief Runs a model over a recording and returns what it expects in a range of it: the current
 * where its source controls the voltage, the voltage elsewhere, with 90 % intervals.
 *
 * In the recording it was fitted to (same time and current at the end of its window), the model
 * runs on from the state it ended with. Otherwise, or for a range before that, it runs from the
 * first sample, whose state is taken from the first second's voltage (paper, eq. 5, median), so
 * inside a later range nothing is used but its inputs. Across gaps the battery is taken to rest.
 */
FollowedPrediction predictSeries(const FittedModel& model, const Series& series, IndexRange range);

}  // namespace battery_sof
