#pragma once

#include <stdexcept>
#include <string>

namespace battery_sof::test {

/// @return what a call says that refuses its arguments; empty when it accepts them.
template <typename Call>
std::string refusalOf(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace battery_sof::test
