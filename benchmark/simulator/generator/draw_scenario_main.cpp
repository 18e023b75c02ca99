#include <iostream>

#include "simulator/generator/draw_scenario_command.hpp"

int main(int argc, char** argv) {
  return battery_sof_simulator::runDrawScenario({argv + 1, argv + argc}, std::cout, std::cerr);
}
