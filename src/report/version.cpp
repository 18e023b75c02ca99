#include "battery_sof/version.hpp"

namespace battery_sof {

std::string version() { return BATTERY_SOF_VERSION; }

}  // namespace battery_sof
