#include <iostream>

#include "cli/sof.hpp"
#include "simulator/simulate_command.hpp"
#include "util/files.hpp"

namespace {

battery_sof::ExternalCommand simulators(const char* name, const char* description,
                                        decltype(&battery_sof_simulator::runSimulate) run) {
  return {name, description, [run](const auto& arguments, std::ostream& out, std::ostream& err) {
            return run(arguments, out, err, battery_sof::requireSeparateFiles);
          }};
}

}  // namespace

int main(int argc, char** argv) {
  return battery_sof::runSof(
      {argv + 1, argv + argc}, std::cout, std::cerr,
      {simulators("simulate", "the reference simulator: a recording from a scenario",
                  battery_sof_simulator::runSimulate),
       simulators("demo", "an example recording to try the other commands on",
                  battery_sof_simulator::runDemo)});
}
