#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace battery_sof {

/**
 * @brief Writes content to a file that appears whole or not at all: written beside under another name, then renamed.
 * Where the file system allows it has no name before, so that a process that is ended meanwhile leaves nothing behind.
 *
 * An existing file is replaced, through a symbolic link too. A device or pipe (/dev/null, /dev/stdout) cannot be renamed
 * onto and is written to directly.
 * @throws std::runtime_error naming the path and the system's reason; nothing is left behind then.
 */
void writeFileAtomically(const std::filesystem::path& path, const std::string& content);

/**
 * @brief The same for content that a library writes: `write` is given a name under which the file can be opened for writing.
 * @throws std::runtime_error likewise, also for a device or pipe, and what `write` throws; nothing is left behind then.
 */
void writeFileAtomically(const std::filesystem::path& path, const std::function<void(const std::filesystem::path&)>& write);

}  // namespace battery_sof
