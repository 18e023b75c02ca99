#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "simulator/simulation.hpp"

namespace battery_sof_simulator {

/// A scenario file that cannot be used; the message lists every fault.
class ScenarioError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A scenario from YAML.
///
/// Top level: name, seed, duration_s, voltage_limit_v, slew_a_per_s, soc, temperature_degc,
/// impedance_current_a, the maps battery, effects, additions, acquisition (keys and bounds in
/// fields.hpp, meaning and defaults at the structs) and profile, and the list inserts. A profile
/// has `kind`: alternating, long_charges, city_drive, or phases with a list `phases` of
/// {duration_s, current_a, to_current_a, voltage_limit_v}, the last two optional; an insert is
/// {at_s, phases}. Ranges are written [low, high]. All but profile.kind may be left out.
/// @param text  YAML.  @param source its name in messages.
/// @throws ScenarioError for unreadable YAML, or listing every wrong key, type and value.
Scenario parseScenario(const std::string& text, const std::string& source);

/// parseScenario() of a file. @throws ScenarioError, also when the file cannot be read.
Scenario loadScenario(const std::filesystem::path& path);

}  // namespace battery_sof_simulator
