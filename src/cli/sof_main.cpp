#include <iostream>

#include "battery_sof/cli/sof.hpp"

int main(int argc, char** argv) {
  return battery_sof::runSof({argv + 1, argv + argc}, std::cout, std::cerr);
}
