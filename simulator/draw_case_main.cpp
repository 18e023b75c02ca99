#include <iostream>

#include "simulator/draw_case_command.hpp"

int main(int argc, char** argv) {
  return battery_sof_reference::runDrawCase({argv + 1, argv + argc}, std::cout, std::cerr);
}
