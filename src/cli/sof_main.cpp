#include <iostream>

#include "cli/sof.hpp"
#include "simulator/simulate_command.hpp"
#include "util/files.hpp"

int main(int argc, char** argv) {
  const battery_sof::ExternalCommand simulate = {
      "simulate", "the reference simulator: a recording from a scenario",
      [](const auto& arguments, std::ostream& out, std::ostream& err) {
        return battery_sof_simulator::runSimulate(arguments, out, err,
                                                  battery_sof::requireSeparateFiles);
      }};
  const battery_sof::ExternalCommand demo = {
      "demo", "an example recording to try the other commands on",
      [](const auto& arguments, std::ostream& out, std::ostream& err) {
        return battery_sof_simulator::runDemo(arguments, out, err,
                                              battery_sof::requireSeparateFiles);
      }};
  return battery_sof::runSof({argv + 1, argv + argc}, std::cout, std::cerr, {simulate, demo});
}
