#pragma once

#include <optional>
#include <vector>

#include "battery_sof/series.hpp"
#include "prediction/event_corrections.hpp"
#include "recording/events.hpp"
#include "state/fitted_model.hpp"
#include "state/state_tracker.hpp"

namespace battery_sof {

/// What ended with a sample and was compared with the model's expectation.
struct SessionEvents {
  std::vector<EventComparison> cranks, charges, stops;
};

/// A sample as the watches take it.
struct WatchedSample {
  const Sample& sample;
  const EventDetector& detector;  ///< moved on to it
  const StateTracker& before;     ///< as it stood before it
  double max_gap;                 ///< [s], longest interval that is joined
  bool is_gap;                    ///< behind a longer one: what was under way is dropped
};

/// Compares cranks: the model is frozen at the last sample before one and run over the crank's own
/// current. `modelled` is without the correction by past cranks.
class CrankWatch {
 public:
  /// @return the comparison when this sample ends a crank.
  std::optional<EventComparison> add(const WatchedSample& at);
  /// What the last crank missed by more than the whole interval that was given: the answer right
  /// before it, or the one that stood before the stop, which knows nothing of what passes in it.
  const std::optional<MissedAnswer>& missed() const { return missed_; }

 private:
  std::optional<EventComparison> compare();

  std::optional<MissedAnswer> missed_;
  std::optional<FittedModel> model_;  // set while the current is at crank level
  Series crank_;
};

/**
 * @brief Compares the model's mean current at a charge's measured voltage with the measured one: the
 * error of SOF2 (docs/physics.md#sof2). `modelled` is without the correction by past charges.
 *
 * A charge is compared after compare_after; a shorter one is dropped. The model is frozen at the
 * last sample before it.
 *
 * Of a model with a source it is what followWindow() takes from a window: nine in ten of its samples
 * have a controlled voltage (beginningOfCharge()); one that begins inside another is left out. The
 * comparison waits for the samples that show its last voltages (StateTracker).
 */
class ChargeWatch {
 public:
  /// @param compare_after [s], beginnings of that length are compared.
  explicit ChargeWatch(double compare_after = kComparedSpans[0]) : compare_after_(compare_after) {}
  /// @return the comparison when this sample completes one.
  std::optional<EventComparison> add(const WatchedSample& at);

 private:
  /// A charge under way, or complete and waiting for what shows its voltages.
  struct Charge {
    FittedModel model;    // as it stood at the last sample before
    Series samples;       // from its first one on
    std::size_t own = 0;  // of the samples; 0 while it is not complete
    // of its own samples, those whose voltage is known to be controlled
    std::size_t controlled = 0;
  };

  static EventComparison compare(const Charge& charge);
  std::optional<EventComparison> finishComplete(const WatchedSample& at);
  void judgeLast(const StateTracker& before);

  double compare_after_;  // [s]
  std::optional<Charge> running_, complete_;
};

/**
 * @brief Compares the voltage 10 s and 30 s into a stop with what the model expected before it;
 * `modelled` is without the correction by past stops.
 *
 * The model is frozen at the last sample before the stop and follows the current that really flowed.
 * A stop ends with the first current that is none, a crank's too. Only where a charger controls the
 * model's voltage.
 */
class StopWatch {
 public:
  /// @return the comparison when this sample completes one.
  std::optional<EventComparison> add(const WatchedSample& at);

 private:
  struct Stop {
    explicit Stop(const FittedModel& before) : model(before), estimator(before) {}
    FittedModel model;  // as it stood at the last sample before
    StateEstimator estimator;
    std::size_t compared = 0;
    // of a slow voltage channel: what was modelled, and samples until it is shown
    std::optional<FollowedSample> modelled = std::nullopt;
    std::size_t waits = 0;
  };

  EventComparison compare(double voltage) const;

  std::optional<Stop> running_;
};

/// Finds events as they pass, one detector for all, and compares the model with them.
class EventWatch {
 public:
  explicit EventWatch(const EventLimits& limits) : limits_(limits), detector_(limits) {}

  /// Moves on to a sample. @param before the tracker as it stood before it.
  WatchedSample advance(const Sample& sample, const StateTracker& before, double max_gap);
  /// Forgets what is under way.
  void reset() { *this = EventWatch(limits_); }
  /// Begins behind a sample: what is under way there is not compared.
  void beginBehind(double current) {
    reset();
    detector_.beginBehind(current);
  }

  CrankWatch cranks;
  ChargeWatch charges;
  ChargeWatch long_charges{kComparedSpans[1]};  ///< of a model with a source, in addition
  StopWatch stops;

 private:
  EventLimits limits_;
  EventDetector detector_;
};

}  // namespace battery_sof
