#pragma once

#include "prediction/cranking.hpp"

namespace battery_sof {

/// How long may the engine stay off?
struct StopTimeQuery {
  double i_load = 0.0;                               ///< [A], <= 0
  double i_cranking = 0.0;                           ///< [A], < 0
  double t_cranking = 1.0;                           ///< [s], > 0 to 60
  double u_required = 0.0;                           ///< [V], above 0 to 100: what the starter needs
  CurrentProfile crank = {};                         ///< in place of i_cranking and t_cranking when not empty
  std::optional<double> temperature = std::nullopt;  ///< [K], of the battery, when known
};

/// The question of a request, as asked() of a crank. Without an u_required nothing is asked, and the answer says so.
StopTimeQuery asked(StopTimeQuery request);

/// What kind of stop time was found.
enum class StopTimeOutcome {
  kFinite,   ///< the crank fails after t_stop
  kAtLeast,  ///< it holds after every stop up to t_stop, the longest that the model's equations hold for
  kAlways,   ///< nothing is drawn (i_load = 0) and it holds after every stop up to a day
  kNever,    ///< it fails even at once
};

/// @return "finite", "at_least", "always" or "never".
std::string toString(StopTimeOutcome outcome);

/// The longest stop. t_stop is present unless code is kInvalidQuery or kNoModel.
struct StopTimeAnswer {
  StopTimeOutcome outcome = StopTimeOutcome::kNever;
  /// [s]; 0 for never, infinite for always. lower: after it the crank's lower bound no longer holds; upper: its upper bound.
  /// None is infinite where something is drawn, and none of the stops draws more than the capacity.
  std::optional<Interval> t_stop;
  bool monotone = true;  ///< the crank's voltage falls with the length of the stop throughout
  bool valid = false;
  AnswerCode code = AnswerCode::kOk;
  std::string message;
};

/**
 * @brief Longest stop after which the crank still holds u_required (docs/physics.md#stop-time).
 *
 *     t_stop = sup { t : u_SOF1(t') >= u_required for all t' <= t }
 *
 * Looked for on stops of 0, 0.5 s and half as much more each, then by regula falsi to 0.1 s or 1 %. u_SOF1 rises at
 * first when the battery recovers from a heavy discharge: the first crossing counts, and monotone says so.
 *
 * A stop is no longer than a day and draws no more than the capacity: t_stop |i_load| <= capacity, the interval's ends
 * too. Where the crank still holds after the charge that the equations hold for (supportedCharge()), t_stop is that stop
 * and the outcome kAtLeast; the message says what the model puts the end at. valid follows extrapolationOf(); an interval
 * from no stop to the longest says nothing, and neither does one that rests on a crank whose interval says nothing.
 *
 * @param capacity [Ah], nominal, > 0.
 */
StopTimeAnswer predictStopTime(const FittedModel& model, const StopTimeQuery& query, double capacity = 50.0);

}  // namespace battery_sof
