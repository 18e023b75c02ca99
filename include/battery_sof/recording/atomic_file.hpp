#pragma once

#include <filesystem>
#include <string>

namespace battery_sof {

/**
 * @brief Writes content to a file that appears whole or not at all: written beside under another name, then renamed.
 *
 * An existing file is replaced, through a symbolic link too. A device or pipe (/dev/null, /dev/stdout) cannot be renamed
 * onto and is written to directly.
 * @throws std::runtime_error naming the path and the system's reason; nothing is left behind then.
 */
void writeFileAtomically(const std::filesystem::path& path, const std::string& content);

}  // namespace battery_sof
