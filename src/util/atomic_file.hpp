#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace battery_sof {

/// @return what is written to for this path: the end of its symbolic links, which need not be
/// there; the path itself where they are a loop.
std::filesystem::path linkTarget(const std::filesystem::path& path);

/**
 * @brief Writes content to a file that appears whole or not at all: written under another name
 * in the same folder, then renamed. Where the file system allows it has no name before, so that a
 * process that is ended meanwhile leaves nothing behind.
 *
 * An existing file is replaced. A symbolic link stays, and what it names is written, whether it is
 * there or not. A device or pipe (/dev/null, /dev/stdout) cannot be renamed onto and is written to
 * directly.
 * @throws std::runtime_error naming the path and the system's reason; nothing is left behind then.
 */
void writeFileAtomically(const std::filesystem::path& path, const std::string& content);

/**
 * @brief The same for content that a library writes: `write` is given a name under which the file
 * can be opened for writing.
 * @throws std::runtime_error likewise, also for a device or pipe, and what `write` throws; nothing
 * is left behind then.
 */
void writeFileAtomically(const std::filesystem::path& path,
                         const std::function<void(const std::filesystem::path&)>& write);

}  // namespace battery_sof
