#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

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

/**
 * @brief The bytes of a regular file, read without ever waiting: a pipe or a device is refused, not
 * opened for long.
 * @param largest [bytes]; a larger file is refused before it is read.
 * @throws std::runtime_error naming the file, what is wrong with it (not there, too large, no
 * regular file, the system's reason) and what was expected.
 */
std::string readRegularFile(const std::filesystem::path& path, std::size_t largest);

/**
 * @brief Refuses to write over what is read, and to write one file twice, before any work is done.
 *
 * Files are compared, not names: a symbolic link, a hard link and "./x" are the file they lead to.
 * Files that are not there yet are compared by folder and name. Empty names, "-", devices and pipes
 * are passed over.
 *
 * @param read, written as given on a command line; one file may be read twice.
 * @throws std::invalid_argument naming both.
 */
void requireSeparateFiles(const std::vector<std::string>& read,
                          const std::vector<std::string>& written);

}  // namespace battery_sof
