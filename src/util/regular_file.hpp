#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace battery_sof {

/**
 * @brief The bytes of a regular file, read without ever waiting: a pipe or a device is refused, not
 * opened for long.
 * @param largest [bytes]; a larger file is refused before it is read.
 * @throws std::runtime_error naming the file, what is wrong with it (not there, too large, no
 * regular file, the system's reason)
 *   and what was expected.
 */
std::string readRegularFile(const std::filesystem::path& path, std::size_t largest);

}  // namespace battery_sof
