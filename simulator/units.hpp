#pragma once

namespace battery_sof_simulator {

inline constexpr double kPi = 3.14159265358979323846, kTwoPi = 2.0 * kPi;
inline constexpr double kSecondsPerHour = 3600.0, kSecondsPerMinute = 60.0;

}  // namespace battery_sof_simulator
