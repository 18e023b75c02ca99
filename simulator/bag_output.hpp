#pragma once

#include <filesystem>

#include "simulator/simulation.hpp"

namespace battery_sof_simulator {

/**
 * @brief Writes a simulated recording as a bag, as writeRecording() says.
 * @throws std::exception when it cannot be written; std::runtime_error of a build without ROS,
 * which says so.
 */
void writeBag(const std::filesystem::path& path, const Simulation& simulation,
              bool with_temperature);

}  // namespace battery_sof_simulator
