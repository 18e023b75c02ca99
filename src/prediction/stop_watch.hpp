#pragma once

#include <optional>

#include "prediction/answer.hpp"
#include "prediction/sample_stream.hpp"
#include "prediction/state_tracker.hpp"

namespace battery_sof {

/// The voltage some time into a stop, and what the model expected of it before the stop.
struct StopComparison {
  double time = 0.0;              ///< [s], of its beginning
  double duration = 0.0;          ///< [s] since then: 10 or 30
  double current = 0.0;           ///< [A], at that moment
  double measured_voltage = 0.0;  ///< [V]
  Interval expected_voltage;      ///< [V]
  double modelled_voltage = 0.0;  ///< [V], without the correction by past stops
};

/**
 * @brief Finds stops as they begin and compares the voltage after 10 s and after 30 s with what the
 * model expected before.
 *
 * A stop begins with the first load below the rule's least current (isStopLoad()) and ends with the
 * first current that is none, a crank's too. The model is frozen at the last sample before it and
 * follows the current that really flowed. Only where a charger controls the model's voltage.
 */
class StopWatch {
 public:
  /// As CrankWatch::add(). @return the comparison when this sample completes one.
  std::optional<StopComparison> add(const StreamSample& sample, const StateTracker& before,
                                    double max_gap);
  void reset() { running_.reset(); }
  /// Begins behind a sample: a stop that is under way there is not compared.
  void beginBehind() {
    reset();
    was_load_ = true;
  }

 private:
  struct Stop {
    FittedModel model;  // as it stood at the last sample before
    Follower follower;
    MissedCrank missed;
    double time, current;  // of the newest sample [s], [A]
    std::size_t compared = 0;
    // of a slow voltage channel: what was modelled, and samples until it is shown
    std::optional<FollowedSample> modelled = std::nullopt;
    std::size_t waits = 0;
  };

  StopComparison compare(double voltage) const;

  bool was_load_ = true;
  std::optional<Stop> running_;
};

}  // namespace battery_sof
