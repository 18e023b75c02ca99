#pragma once

#include <optional>

#include "prediction/charge_acceptance.hpp"
#include "prediction/sample_stream.hpp"
#include "prediction/state_tracker.hpp"

namespace battery_sof {

/// A charge that began, and what the model expected of the voltage that really stood.
struct ChargeComparison {
  double time = 0.0;              ///< [s], of the first sample
  double duration = 0.0;          ///< [s]
  double mean_voltage = 0.0;      ///< [V]
  double first_voltage = 0.0;     ///< [V], at its first sample
  double measured_current = 0.0;  ///< [A], mean
  Interval expected_current;      ///< [A], mean
  /// [A], mean, without the correction by past charges
  double modelled_current = 0.0;
  /// [A], by the window's baseline predictor; see BaselineSelector
  std::optional<Interval> baseline_current = std::nullopt;
  /// a question before it was answered by that one
  bool baseline_answered = false;
};

/**
 * @brief Finds charges as they begin and compares the model's current at the measured voltage with
 * the measured one: the error of SOF2 (docs/physics.md#sof2).
 *
 * A charge begins when the current rises above 2 A from below it and is compared after 10 s; a
 * shorter one is dropped. The model is frozen at the last sample before it.
 *
 * Of a model with a source it is what followWindow() takes from a window: it begins with the first
 * controlled voltage and current above 0 after a discharge (chargeBeginnings()), and nine in ten of
 * its samples have a controlled voltage (beginningOfCharge()); one that begins inside another is
 * left out. The comparison waits for the samples that show its last voltages (StateTracker).
 */
class ChargeWatch {
 public:
  /// @param compare_after [s], beginnings of that length are compared.
  explicit ChargeWatch(double compare_after = 10.0) : compare_after_(compare_after) {}
  /// As CrankWatch::add(). @return the comparison when this sample completes one.
  std::optional<ChargeComparison> add(const StreamSample& sample, const StateTracker& before,
                                      double max_gap);
  void reset();
  /// Begins behind a sample: a charge that is under way there is not compared.
  void beginBehind(double current);

 private:
  /// A charge under way, or complete and waiting for what shows its voltages.
  struct Charge {
    FittedModel model;    // as it stood at the last sample before
    MissedCrank missed;   // of the discharge before it
    Series samples;       // from its first one on
    std::size_t own = 0;  // of the samples; 0 while it is not complete
    // of its own samples, those whose voltage is known to be controlled
    std::size_t controlled = 0;
  };

  static std::size_t waitsFor(const Fit& fit);
  static ChargeComparison compare(const Charge& charge);
  std::optional<ChargeComparison> finishComplete(const StreamSample& sample,
                                                 const StateTracker& before, bool is_gap);
  void judgeLast(const StateTracker& before);
  bool isOver(const StreamSample& sample, const StateTracker& before) const;
  bool begins(const StreamSample& sample, const StateTracker& before);

  double compare_after_;     // [s]
  bool charging_ = false;    // by the current
  bool discharged_ = false;  // since the last charge began
  std::optional<Charge> running_, complete_;
};

}  // namespace battery_sof
