#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bag/format/battery_state_message.hpp"

namespace battery_sof {

/**
 * @brief Writes a bag of format 2.0 with one topic as rosbag does: chunks of 768 kB, not compressed.
 *
 * Record times are the messages' stamps, but at least 1 ns, since 0 is no record time of rosbag; the
 * stamp, which is the clock, may be 0.
 * @param messages with stamps that do not fall.
 * @throws std::runtime_error when the file cannot be written.
 */
void writeBatteryStates(const std::filesystem::path& path, const std::string& topic,
                        const std::vector<BatteryStateMessage>& messages);

}  // namespace battery_sof
