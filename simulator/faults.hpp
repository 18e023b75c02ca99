#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace battery_sof_simulator {

/// @throws std::invalid_argument, "where: fault; fault", unless there are none.
inline void requireNone(const std::vector<std::string>& faults, const std::string& where) {
  std::string text;
  for (const auto& fault : faults) text += (text.empty() ? "" : "; ") + fault;
  if (!text.empty()) throw std::invalid_argument(where + ": " + text);
}

/// "name is value, expected ..."
inline std::string faultOf(const std::string& name, double value, const std::string& expected) {
  return name + " is " + std::to_string(value) + ", expected " + expected;
}

}  // namespace battery_sof_simulator
