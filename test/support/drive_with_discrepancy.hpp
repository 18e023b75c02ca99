#pragma once

#include <cmath>
#include <memory>

#include "regression/discrepancy_fit.hpp"
#include "support/composed.hpp"

/// A recording of a battery whose charging leaves a memory that no equation and no regressor has,
/// and what is estimated of it.
namespace battery_sof::test {

/// The base circuit at 20 Hz with 1 mV of noise, and the square root of what ten seconds of
/// charging leave.
inline Series withMemoryOfCharging(double duration, double strength = 0.02) {
  Series series = recordingOf({}, duration);
  double memory = 0.0;
  for (std::size_t n = 1; n < series.size(); ++n) {
    memory += -std::expm1(-(series.time[n] - series.time[n - 1]) / 10.0) *
              (std::max(series.current[n], 0.0) - memory);
    series.voltage[n] += strength * std::sqrt(memory);
  }
  return series;
}

/// Estimated beside the true circuit from the samples before `last`.
inline std::shared_ptr<const DiscrepancyModel> discrepancyLearntFrom(const Series& series,
                                                                     std::size_t last) {
  const InputSequence inputs = inputSequence(series, {0, last});
  const ModelPoint truth = pointOf(BatteryModel(), typicalPoint(BatteryModel()));
  const Linearization response = discrepancyLinearizationOf(BatteryModel(), truth, inputs, last);
  return std::make_shared<const DiscrepancyModel>(
      fitDiscrepancy(response, designMatrix(inputs, response, drivenBattery().beta), isTimeless)
          .discrepancy);
}

}  // namespace battery_sof::test
