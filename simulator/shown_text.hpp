#pragma once

#include <string>

namespace battery_sof_simulator {

/// @return a text of outside (a file's name, a piece of a scenario) as one line of UTF-8 that a
/// terminal shows and does not obey: control characters and bytes that are not UTF-8 become \xNN.
/// What is longer than some thousands of bytes is cut off.
std::string shown(const std::string& text);

}  // namespace battery_sof_simulator
