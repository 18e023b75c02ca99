#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace battery_sof {

/// @return the cell's text; where cells end with semicolons or tabs, a single comma without a point
/// next to it is the decimal sign, and becomes a point.
std::string withPoint(std::string_view cell, char separator);

/// @return the whole cell as a number, NaN for an empty one; none when it is text.
std::optional<double> parseNumber(std::string_view cell);

/// @return "2017-03-25 07:00:06.900", with T for the space and with a closing Z or an offset
/// (+01:00, -0500, +01) too, as seconds since 1970-01-01 UTC; none for anything else.
std::optional<double> parseDateTime(std::string_view cell);

}  // namespace battery_sof
