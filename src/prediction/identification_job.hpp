#pragma once

#include <deque>
#include <optional>
#include <string>

#include "battery_sof/series.hpp"
#include "estimation/identification.hpp"
#include "prediction/model_monitor.hpp"
#include "recording/control_mode.hpp"
#include "recording/events.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/// Which share of the samples that are kept has a controlled voltage: judged over a recording at
/// once, then sample by sample.
class ChargerShare {
 public:
  /// Nothing is known of a source.
  ChargerShare() = default;
  /// A rule from an earlier run.
  explicit ChargerShare(const ControlModeRule& rule);
  /// Over a recording (detectControlMode()); goes on from its last sample.
  ChargerShare(const Series& series, const ControlModes& source);

  /// A sample later than the ones before.
  void add(const Sample& sample);
  /// Drops blocks of 10 s that end before `time` [s].
  void forgetBefore(double time);
  /// The clock jumped: nothing is kept.
  void forgetPast();

  bool seen() const { return seen_; }   ///< something charges the battery
  std::optional<double> share() const;  ///< [0, 1]; none where nothing was judged
  std::optional<double> until() const;  ///< [s], of the last sample

 private:
  struct Block {
    double from = 0.0, to = 0.0;  // [s]
    std::size_t samples = 0, controlled = 0;
  };
  void count(double time, bool controlled);

  bool seen_ = false;
  std::optional<ControlModeDetector> watch_;
  std::deque<Block> blocks_;
};

/// How a session's models are identified.
struct IdentificationSettings {
  std::optional<double> window_length;  ///< [s]; else defaultWindowLength()
  double min_window_quality = 0.2;      ///< [0, 1], a window below it is not fitted
  EventLimits events;                   ///< what counts as a crank
  AnswerSteps steps;
  IdentifyOptions identify;
};

/// Everything an identification needs, copied, so that any thread can run it.
struct IdentificationJob : IdentificationSettings {
  Series series;                         ///< the buffered samples
  std::optional<FittedModel> incumbent;  ///< the model in use, to be compared with
};

/// What a job came to: a fit, and how it compares with the model before it.
struct IdentificationResult {
  /// state at the series' last sample; none when no window could be fitted
  std::optional<FittedModel> model;
  std::string message;  ///< one sentence
  /// The same model as it followed the samples behind its window, with the events that passed
  /// there; none where it is not usable.
  std::optional<ModelMonitor> followed;
  double recent_rmse = 0.0;  ///< [V], of the model over the most recent window
  /// [V], of the incumbent over the same samples, driven in the same direction
  std::optional<double> incumbent_rmse = std::nullopt;
  /// [A], of both where the voltage is the input; 0 where it is not
  double recent_current_rmse = 0.0, incumbent_current_rmse = 0.0;
  /// [1], error of the model over the incumbent's: of each quantity where it is not the input, their
  /// geometric mean by samples; at most 1 where both are negligible
  double worsening = 1.0;
  ChargerShare source;  ///< over the series
};

/// The most recent stretch without a gap, at most `length` [s] long; empty for an empty series.
IndexRange recentWindow(const Series& series, double length);

/**
 * @brief Chooses a window, fits it and carries the state to the series' last sample. Reads and
 * changes nothing else.
 *
 * A model whose voltage a source controls keeps past events (EventHistory): those of its window,
 * and of the samples behind it.
 *
 * Both models' errors over recentWindow() are open-loop runs that start from the measured voltage
 * of its first samples, so neither profits from having been there. Both are driven as the new
 * model's source asks, over the same samples, without those that are no measurement.
 *
 * @return without a model where a fit throws; the message says why. A job always has a result, which
 * OnlineSession::finish() needs before the next one.
 */
IdentificationResult runIdentification(const IdentificationJob& job);

}  // namespace battery_sof
