#pragma once

#include <string>

namespace battery_sof {

/// @return the package's version, e.g. "0.3.0".
std::string version();

}  // namespace battery_sof
