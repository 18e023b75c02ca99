#pragma once

namespace battery_sof {

inline constexpr double kPi = 3.14159265358979323846;

}  // namespace battery_sof
