#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "simulator/impedance.hpp"
#include "simulator/simulation.hpp"

namespace battery_sof_simulator {

/// How finely a CSV is written: as a sensor's resolution needs, 0.1 mA and 1 uV; or so that small
/// differences of recordings without noise are kept, 0.1 uA and 1 nV.
enum class Digits { kSensor, kMany };

/**
 * @brief Writes a simulated recording; the file appears whole or not at all.
 *
 * .csv: time_s,current_a,voltage_v, and temperature_c when `with_temperature`.
 * .bag: sensor_msgs/BatteryState on /battery_state, header stamps as the samples' times, other
 * fields NaN; the bag's own record times are the stamps too, but at least ros::TIME_MIN, the
 * smallest rosbag takes.
 *
 * @throws std::invalid_argument for another extension; std::runtime_error when it cannot be
 * written.
 */
void writeRecording(const std::filesystem::path& path, const Simulation& simulation,
                    bool with_temperature, Digits digits = Digits::kSensor);

/// Writes frequency_hz,real_ohm,imag_ohm,analytic_real_ohm,analytic_imag_ohm, whole or not at all.
/// @throws std::runtime_error.
void writeImpedance(const std::filesystem::path& path, const std::vector<ImpedancePoint>& spectrum);

/// Writes a text file whole or not at all. @throws std::runtime_error.
void writeText(const std::filesystem::path& path, const std::string& text);

/// @return whether writeRecording() knows the path's extension.
bool isRecordingName(const std::filesystem::path& path);

}  // namespace battery_sof_simulator
