#pragma once

#include <filesystem>

#include "battery_sof/recording_error.hpp"

namespace battery_sof {

/**
 * @brief Walks the records of a bag (format 2.0) from its first byte to its last and checks that
 * every length, in connections too, and every index entry points to where a record is.
 *
 * rosbag_storage trusts these numbers: one damaged byte in them makes it read beyond its buffers,
 * or allocate what the byte says. A compressed chunk may claim to hold up to a thousand times its
 * bytes, or 4 MiB; its contents are left to their own checksums. A chunk may be listed once.
 *
 * @throws RecordingError naming the file, the byte and what is wrong there; for a bag of another
 *   format, one that is encrypted, and one without an index too.
 */
void requireSoundBag(const std::filesystem::path& path);

}  // namespace battery_sof
