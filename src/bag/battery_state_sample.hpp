#pragma once

#include "bag/format/battery_state_message.hpp"
#include "battery_sof/intake.hpp"

namespace battery_sof {

/**
 * @brief The one reading of a sensor_msgs/BatteryState, for bags and the node alike; the header
 * stamp is the clock.
 *
 * The message holds 32-bit floats. Each is taken as the shortest decimal that reads back to it
 * (12.275, not 12.274999618530273), so a CSV and the bag made of it hold the same numbers up to
 * seven digits.
 *
 * @return current [A], voltage [V], temperature [K] (message: degC), none when NaN. Nothing is
 * judged here: see Intake. A stamp whose nanoseconds make a second or more is no time; it becomes
 * one that Intake counts as out of range.
 */
RawSample rawSampleOf(const BatteryStateMessage& message);

/// @return the message of one sample. @throws std::invalid_argument for a time stampOf() refuses.
BatteryStateMessage batteryStateOf(const RawSample& sample);

/**
 * @return stamp rounded to the nanosecond.
 * @throws std::invalid_argument when time [s] is not finite, negative, or beyond a stamp's 2^32 s.
 */
Stamp stampOf(double time);

/// @return the double nearest to the stamp [s]; stampOf() of it is the stamp again to within 1 ns
/// up to 2^22 s, and to within the double's own step (0.24 us at 2^30 s) above.
double secondsOf(const Stamp& stamp);

}  // namespace battery_sof
