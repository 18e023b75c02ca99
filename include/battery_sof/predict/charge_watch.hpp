#pragma once

#include <optional>

#include "battery_sof/predict/charge_acceptance.hpp"
#include "battery_sof/predict/sample_stream.hpp"
#include "battery_sof/predict/state_tracker.hpp"

namespace battery_sof {

/// A charge that began, and what the model expected of the voltage that really stood.
struct ChargeComparison {
  double time = 0.0;              ///< [s], of the first sample
  double duration = 0.0;          ///< [s]
  double mean_voltage = 0.0;      ///< [V]
  double first_voltage = 0.0;     ///< [V], at its first sample
  double measured_current = 0.0;  ///< [A], mean
  Interval expected_current;      ///< [A], mean
  double modelled_current = 0.0;  ///< [A], mean, without what past charges taught
};

/**
 * @brief Finds charges as they begin and sets the model's current at the measured voltage beside the measured one: the
 * error of SOF2 (PHYSICS 2.7).
 *
 * A charge begins when the current rises above 2 A from below it and is compared after 10 s; a shorter one is dropped.
 * The model is frozen at the last sample before it.
 */
class ChargeWatch {
 public:
  /// As CrankWatch::add(). @return the comparison when this sample completes one.
  std::optional<ChargeComparison> add(const StreamSample& sample, const StateTracker& before,
                                      double max_gap);
  void reset();

 private:
  std::optional<FittedModel> model_;  // set from a charge's first sample until it was compared
  MissedCrank missed_;                // of the discharge before it
  bool charging_ = false;
  Series charge_;
};

}  // namespace battery_sof
