#pragma once

#include <filesystem>
#include <string>

#include "battery_sof/recording_error.hpp"
#include "battery_sof/series.hpp"

namespace battery_sof {

/// Topic of the node and the default of every tool.
inline constexpr char kDefaultTopic[] = "battery_state";

/**
 * @brief Reads a recording from a bag of sensor_msgs/BatteryState; the header stamps are the clock.
 *
 * @param topic with or without a leading slash.
 * @throws RecordingError when the file is not a readable bag (truncated, not indexed, not a bag),
 * has no such topic (the message lists the topics it has), or the topic carries another message
 * type.
 */
Recording readBag(const std::filesystem::path& path, const std::string& topic = kDefaultTopic);

/**
 * @brief Writes a bag with one sensor_msgs/BatteryState for each of rawSamplesOf(series): header
 * stamp and record time are the sample's time.
 *
 * current [A] negative when discharging, voltage [V], temperature [degC] or NaN; fields not
 * measured are NaN. The file appears whole or not at all.
 * @throws RecordingError when a time is negative or beyond what a ROS stamp holds, or the file
 * cannot be written.
 */
void writeBag(const std::filesystem::path& path, const Series& series,
              const std::string& topic = kDefaultTopic);

}  // namespace battery_sof
