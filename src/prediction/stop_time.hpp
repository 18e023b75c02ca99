#pragma once

#include "prediction/cranking.hpp"

namespace battery_sof {

/// The question of a request, as asked() of a crank. Without an u_required there is no
/// question, and the answer says so.
StopTimeQuery asked(StopTimeQuery request);

/**
 * @brief Longest stop after which the crank still holds u_required (docs/physics.md#stop-time).
 *
 *     t_stop = sup { t : u_SOF1(t') >= u_required for all t' <= t }
 *
 * Looked for on stops of 0, 0.5 s and half as much more each, then by regula falsi to 0.1 s or 1 %.
 * u_SOF1 rises at first when the battery recovers from a heavy discharge: the first crossing
 * counts, and monotone says so.
 *
 * A stop is no longer than a day and draws no more than the capacity: t_stop |i_load| <= capacity,
 * the interval's ends too. Where the crank still holds after the charge that the equations hold for
 * (supportedCharge()), t_stop is that stop and the outcome kAtLeast; the message says what the
 * model puts the end at. valid follows extrapolationOf(); an interval from no stop to the longest
 * says nothing, and neither does one that rests on a crank whose interval says nothing.
 *
 * @param capacity [Ah], nominal, > 0.
 */
StopTimeAnswer predictStopTime(const FittedModel& model, const StopTimeQuery& query,
                               double capacity = 50.0);

}  // namespace battery_sof
