#pragma once

#include <deque>

#include "model/input_sequence.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/// What the present error says of a load some time ahead.
struct PresentForecast {
  double share = 0.0;     ///< [0, 1], correlation of that load's error with the present one
  double level = 0.0;     ///< [V], measured minus modelled at the present load
  double variance = 0.0;  ///< [V^2], by which such a level missed later voltages of the same load
};

/**
 * @brief Follows what a model misses of the voltage at the load that flows, and learns from its own
 * past how far such an error misses later voltages.
 *
 *     level <- level + g (error - level),   g = max(1 - exp(-duration / 8 s), 1 - rho, duration / s)
 *     rho(i, j) = max(0, 1 - |i - j| / largest current)
 *
 * s is the time for which the load has been the same. The sample of an edge may show one channel
 * before the other, so the next one replaces what it says, and the level is the mean since then
 * until the memory is shorter. Errors at loads apart are different errors, which rho says: a wrong
 * resistance adds one that grows with the difference. The level of a moment behind an edge is held
 * against the error of the next sample, and against those 30 and 120 s later, where the load is then
 * the same within a twentieth; the mean squares, of the last five minutes, are what a forecast
 * misses. Between these spans they are interpolated linearly, beyond them the last two say by which
 * power of time they grow, from a walk (1) to a drift (2).
 *
 * Constant memory. Where the voltage is controlled there is no present load.
 */
class PresentErrorFilter {
 public:
  /// Goes on from what a model has saved.
  explicit PresentErrorFilter(const FittedModel& model);

  void follow(const InputSample& sample, double error);

  const PresentError& state() const { return now_; }

 private:
  /// A level as it stood, to be held against later errors.
  struct Snapshot {
    double time, level, current;
    std::size_t next_span;
  };

  void compare(std::size_t span, double duration, double miss, double length);
  void compareSnapshots(double duration, double error, double current);

  PresentError now_;
  std::deque<Snapshot> snapshots_;
  double clock_ = 0.0;  // [s], since the beginning
};

/// Correlation of the errors at two loads. @param largest [A], current that the model was seen at.
double correlationOfLoads(double one, double other, double largest);

/// [V^2], by which the present level misses the voltage of the same load `ahead` [s] later.
double missedAhead(const PresentError& error, double ahead);

/// Of a load; share 0 where no present error is known. @param ahead [s] from the model's state.
PresentForecast forecastOf(const FittedModel& model, double current, double ahead);

/// What the model was expected to miss of the present voltage when its window was fitted: with a
/// source what past stops say, else nothing; its variance is the window's error, and what past
/// levels missed over the model's age.
ErrorForecast expectedPresentError(const FittedModel& model);

}  // namespace battery_sof
