#pragma once

#include <ros/time.h>
#include <sensor_msgs/BatteryState.h>

#include <cstdint>
#include <vector>

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
RawSample rawSampleOf(const sensor_msgs::BatteryState& message);

/**
 * @brief A serialized message, its lengths checked against its bytes first: roscpp allocates what a
 * list's length says.
 * @throws std::invalid_argument when they do not fit.
 */
sensor_msgs::BatteryState batteryStateIn(std::vector<std::uint8_t>& bytes);

/// @return the message of one sample; every field that is not measured is NaN.
/// @throws std::invalid_argument for a time rosTime() refuses.
sensor_msgs::BatteryState batteryStateOf(const RawSample& sample);

/**
 * @return stamp rounded to the nanosecond.
 * @throws std::invalid_argument when time [s] is not finite, negative, or beyond a stamp's 2^32 s.
 */
ros::Time rosTime(double time);

/// @return the double nearest to the stamp [s]; rosTime() of it is the stamp again to within 1 ns
/// up to 2^22 s, and to within the double's own step (0.24 us at 2^30 s) above.
double secondsOf(const ros::Time& stamp);

}  // namespace battery_sof
