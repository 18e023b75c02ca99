#pragma once

#include <filesystem>

#include "battery_sof/recording/recording_error.hpp"

namespace battery_sof {

/**
 * @brief Walks the records of a bag (format 2.0) from its first byte to its last and checks that
 * every length and every index entry points to where a record is.
 *
 * rosbag_storage trusts these numbers: one damaged byte in them makes it read beyond its buffers.
 * Contents of compressed chunks are left to their own checksums. Bags of other versions are not
 * looked into.
 *
 * @throws RecordingError naming the file, the byte and what is wrong there.
 */
void requireSoundBag(const std::filesystem::path& path);

}  // namespace battery_sof
