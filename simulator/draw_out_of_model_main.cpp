#include <iostream>

#include "simulator/draw_out_of_model_command.hpp"

int main(int argc, char** argv) {
  return battery_sof_reference::runDrawOutOfModel({argv + 1, argv + argc}, std::cout, std::cerr);
}
