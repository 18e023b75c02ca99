#pragma once

#include <deque>

#include "prediction/model_monitor.hpp"

namespace battery_sof {

/// Errors of the base model and of an extended one over the same samples and events.
struct ModelSelectorScore {
  double duration = 0.0;                        ///< [s] of samples compared
  double base_rmse = 0.0, extended_rmse = 0.0;  ///< [V], open loop
  int cranks = 0;
  double base_crank_error = 0.0,
         extended_crank_error = 0.0;  ///< [V], mean magnitude, of the minima
  int charges = 0;
  double base_charge_error = 0.0,
         extended_charge_error = 0.0;  ///< [A], mean magnitude, of the mean currents
};

/**
 * @brief Two models compared over the last 15 min: which one answers.
 *
 * Every sample is predicted by both before it is compared, and identifications do not begin the
 * contest again, so the scores are those of predictions that were really made (prequential; Dawid
 * 1984). Decided every 10 s, by their samples' stamps.
 *
 * The extended model answers from when it has been compared for 2 min, its RMSE is below 0.95 of
 * the base model's (a twentieth stands between a change and chatter) and neither its cranks nor its
 * charges are worse. It stops when its RMSE is no longer below the base model's, or cranks or
 * charges are worse: three or more of them, by more than a tenth and by more than 12.5 mV or 1.25 A
 * on average.
 */
class ModelSelector {
 public:
  static constexpr double kMinDuration = 120.0;  ///< [s]

  /// Takes in a sample and what ended with it. @param base, extended followed it both.
  void add(const StreamSample& sample, const ModelMonitor& base, const SessionEvents& base_events,
           const ModelMonitor& extended, const SessionEvents& extended_events);
  /// Begins to compare again; who answers stays until the new past decides.
  void forgetPast() { blocks_.clear(); }

  bool doesExtendedAnswer() const { return extended_answers_; }
  ModelSelectorScore score() const;

 private:
  /// Sums over an event's kind.
  struct Errors {
    int count = 0;
    double base = 0.0, extended = 0.0;
    void add(double base_error, double extended_error);
    void add(const Errors& other);
    bool isExtendedWorse(double negligible) const;
  };
  /// Sums over 10 s.
  struct Block {
    double from = 0.0, to = 0.0;  // [s], first and last sample
    double duration = 0.0;        // [s], of sampling intervals, longer ones than a block left out
    Errors squares, cranks, charges;
  };

  static double blockOf(double time);
  Block total() const;
  bool isExtendedBetter() const;

  std::deque<Block> blocks_;
  bool extended_answers_ = false;
};

}  // namespace battery_sof
