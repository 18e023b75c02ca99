#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "simulator/simulation.hpp"

namespace battery_sof_simulator {

/// Has a file written that appears whole or not at all: `write` is given a name under which it can
/// be opened for writing. Where the file system can do that it has no name before, so that a
/// process that is killed leaves nothing behind; where a file is replaced it has one,
/// PATH.PID.part, for the moment between naming and renaming, and elsewhere throughout.
/// @throws std::runtime_error naming the path and the reason; nothing is left behind then.
void writeWhole(const std::filesystem::path& path,
                const std::function<void(const std::filesystem::path&)>& write);

/// Writes a recording as a bag, as writeRecording() says.
/// @throws std::exception when it cannot be written.
void writeBag(const std::filesystem::path& path, const std::vector<RecordedSample>& samples,
              const std::vector<double>& temperature);

/// How finely a CSV is written: as a sensor's resolution needs, 0.1 mA and 1 uV; or so that small
/// differences of recordings without noise are kept, 0.1 uA and 1 nV.
enum class Digits { kSensor, kMany };

/// Writes a recording; the file appears whole or not at all. .csv: time_s,current_a,voltage_v, and
/// temperature_c where there is one for each sample [degC]. .bag:
/// sensor_msgs/BatteryState on /battery_state, header stamps as the samples' times, other fields
/// NaN; the bag's own record times are the stamps too, but at least 1 ns.
/// @throws std::invalid_argument for another extension; std::runtime_error when it cannot write.
void writeRecording(const std::filesystem::path& path, const std::vector<RecordedSample>& samples,
                    Digits digits, const std::vector<double>& temperature = {});

/// Writes a text file whole or not at all. @throws std::runtime_error.
void writeText(const std::filesystem::path& path, const std::string& text);

/// @throws std::invalid_argument unless writeRecording() knows the path's extension.
void requireRecordingName(const std::filesystem::path& path);

}  // namespace battery_sof_simulator
