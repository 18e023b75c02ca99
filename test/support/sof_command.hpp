#pragma once

#include "cli/sof.hpp"
#include "support/commands.hpp"

namespace battery_sof::test {

inline Outcome sof(const std::vector<std::string>& arguments) {
  return outcomeOf([](auto&... all) { return runSof(all...); }, arguments);
}

}  // namespace battery_sof::test
