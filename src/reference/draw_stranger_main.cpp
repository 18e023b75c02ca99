#include <iostream>

#include "reference/draw_stranger_command.hpp"

int main(int argc, char** argv) { return battery_sof_reference::runDrawStranger({argv + 1, argv + argc}, std::cout, std::cerr); }
