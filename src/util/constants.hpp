#pragma once

#include <limits>

namespace battery_sof {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kZeroCelsius = 273.15;     ///< [K], by definition
inline constexpr double kSecondsPerHour = 3600.0;  ///< also [As] per [Ah]

}  // namespace battery_sof
