#include <iostream>

#include "battery_sof/cli/sof.hpp"
#include "reference/simulate_command.hpp"

int main(int argc, char** argv) {
  const battery_sof::ExternalCommand simulate = {
      "simulate", "the reference simulator: a recording from a scenario",
      battery_sof_reference::runSimulate};
  return battery_sof::runSof({argv + 1, argv + argc}, std::cout, std::cerr, {simulate});
}
