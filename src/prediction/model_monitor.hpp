#pragma once

#include <cmath>
#include <deque>
#include <optional>
#include <vector>

#include "prediction/event_watch.hpp"
#include "state/state_tracker.hpp"

namespace battery_sof {

/// How a model has done since it was accepted.
struct BacktestScore {
  /// paper, eq. 6, without a look at the voltage but where the model learns; none until it varied
  std::optional<double> q_dyn_percent;
  double duration = 0.0;  ///< [s], from the first to the last sample compared
};

/// The steps from the equations to an answer; experiments leave one out.
struct AnswerSteps {
  bool residual_filter = true, event_history = true, calibration = true;
};

/**
 * @brief A model that follows the samples: its state, its rolling back-test, and the cranks and
 * charges that it was compared with. A copy goes on by itself.
 */
class ModelMonitor {
 public:
  static constexpr double kBacktestSpan = 900.0;  ///< [s] of the past that a back-test looks at

  explicit ModelMonitor(const EventLimits& limits, const AnswerSteps& steps = {})
      : steps_(steps), watch_(limits) {}

  /// Takes a model in the place of the one before; the back-test begins again. @param max_gap [s],
  /// longest interval joined.
  void install(const FittedModel& model, double max_gap);
  /// Shows the samples up to the model's state, right after install(): by them a source is judged,
  /// and a charge under way at the state is not taken for one that begins behind it.
  void lookBack(const Series& series);
  /// Goes on from a model of another trip or of the population: samples are taken into parameters
  /// and state, one in 0.1 s, until a window's fit is installed.
  void learnFrom(const FittedModel& model, double max_gap);
  /// From here on the model that it follows is the one in use; the back-test begins again.
  /// @param model the same with what its caller knows of it.  @param calibrations as the intervals
  /// of the model before asked for.
  void accept(const FittedModel& model, const IntervalCalibrations& calibrations);
  /// Follows no model from here on.
  void drop();
  bool learns() const { return tracker_ && tracker_->learns(); }
  bool holdsModel() const { return tracker_.has_value(); }
  /// Answers nothing valid (denialOf()); looked at once a second of samples and at every crank.
  bool isDenied() const { return tracker_ && is_denied_; }
  /// Whether its numbers are; one that is not cannot be followed further.
  bool isFinite() const {
    return !tracker_ || (std::isfinite(tracker_->error()) && tracker_->state().states.allFinite());
  }

  /// Moves on to a sample; nothing happens without a model, or at or before its state. @return what
  /// ended with it.
  SessionEvents follow(const Sample& sample, double max_gap);

  /// Puts the model onto the first sample of a clock that jumped back: its window, its past events
  /// and its state. What is in progress and compared is dropped. @param moved [s], by how much.
  void restartClock(const Sample& first, double moved, double max_gap);

  /// How wide intervals are, as past events ask for; as of a new model where there is none.
  IntervalCalibrations calibrations() const;
  void setCalibrations(const IntervalCalibrations& calibrations);  ///< needs a model

  // These need a model.
  /// As the tracker has it: parameters as samples moved them, the state where it began.
  const FittedModel& accepted() const { return tracker_->model(); }
  FittedModel now() const { return tracker_->modelNow(); }
  const StateTracker& tracker() const { return *tracker_; }  ///< where it stands
  /// [s], from the end of the model's window to its state.
  double age() const { return tracker_->state().time - accepted().fit.window.to; }

  BacktestScore backtest() const;

 private:
  /// One compared instant of the back-test.
  struct Compared {
    double time, measured, expected;
  };

  SessionEvents compareEvents(const Sample& sample, double max_gap);
  void updateFrom(const PastEvent& event);
  AnswerSteps steps_;
  EventWatch watch_;
  std::optional<StateTracker> tracker_;
  double looked_at_ = -HUGE_VAL;  // [s]
  bool is_denied_ = false;
  std::deque<Compared> compared_;
};

}  // namespace battery_sof
