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
 * charges that it was compared with.
 *
 * Interval calibrations outlive a model: they are the composition's past. A copy goes on by itself.
 */
class ModelMonitor {
 public:
  static constexpr double kBacktestSpan = 900.0;  ///< [s] of the past that a back-test looks at

  explicit ModelMonitor(const EventLimits& limits, const AnswerSteps& steps = {})
      : steps_(steps), watch_(limits) {}

  /// Takes a model in the place of the one before; the back-test begins again. @param max_gap [s],
  /// longest interval joined.
  void install(const FittedModel& model, double max_gap);
  /// Takes a model that already followed samples in another one: its state, and events that are
  /// under way. Its calibrations and back-test stay behind. @param model the same with what its
  /// caller knows of it.
  void goOnAs(const ModelMonitor& other, const FittedModel& model);
  /// Shows the samples up to the model's state, right after install(): by them a source is judged,
  /// and a charge under way at the state is not taken for one that begins behind it.
  void lookBack(const Series& series);
  /// Goes on from a model of another trip or of the population: samples are taken into parameters
  /// and state, one in 0.1 s, until a window's fit is installed.
  void learnFrom(const FittedModel& model, double max_gap);
  bool learns() const { return tracker_ && tracker_->learns(); }
  bool holdsModel() const { return tracker_.has_value(); }
  /// Answers nothing valid (denialOf()); looked at once a second of samples and at every crank.
  bool isDenied() const { return is_denied_; }

  /// Moves on to a sample; nothing happens without a model, or at or before its state. @return what
  /// ended with it.
  SessionEvents follow(const Sample& sample, double max_gap);

  /// Drops what is in progress and compared.
  void forgetPast();
  /// Puts the state onto the first sample of a clock that jumped back. @param moved [s], by how
  /// much.
  void moveTo(const Sample& first, double moved, double max_gap);

  /// As the intervals of earlier models asked for.
  void setCalibrations(const IntervalCalibrations& calibrations);
  const IntervalCalibrations& calibrations() const { return calibrations_; }

  // These need a model.
  const FittedModel& accepted() const { return *model_; }  ///< as it was installed
  FittedModel now() const { return tracker_->modelNow(); }
  const StateTracker& tracker() const { return *tracker_; }  ///< where it stands
  /// [s], end of the model's window on the present clock.
  double fittedUntil() const { return fitted_until_; }

  BacktestScore backtest() const;
  /// @return [V] at which the battery was charged lately: median over the past charges that the
  /// model knows, else over those that passed; none where none was seen.
  std::optional<double> chargeVoltage() const;

 private:
  /// One compared instant of the back-test.
  struct Compared {
    double time, measured, expected;
  };

  SessionEvents watch(const Sample& sample, double max_gap);
  void updateFrom(const PastEvent& event);
  AnswerSteps steps_;
  EventWatch watch_;
  IntervalCalibrations calibrations_;
  std::optional<FittedModel> model_;
  std::optional<StateTracker> tracker_;
  double fitted_until_ = 0.0, looked_at_ = -HUGE_VAL;  // [s]
  bool is_denied_ = false;
  std::deque<Compared> compared_;
  std::deque<double> charge_voltages_;  // [V], means of the last charges that passed
};

}  // namespace battery_sof
