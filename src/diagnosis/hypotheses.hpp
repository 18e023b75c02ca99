#pragma once

#include <string>
#include <vector>

#include "model/battery_model.hpp"

namespace battery_sof {

/// @return a composition with one effect more, and what that one needs.
BatteryModel enlarged(const BatteryModel& model, const std::string& id);

/// @return ids that a diagnosis weighs: those asked for, else all of the catalogue; what is weighed
/// on request alone takes part
///   where a source controls the voltage, which is what it is for.
std::vector<std::string> hypothesesOf(const std::vector<std::string>& asked,
                                      bool voltage_controlled);

}  // namespace battery_sof
