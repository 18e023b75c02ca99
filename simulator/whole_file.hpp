#pragma once

#include <filesystem>
#include <functional>

namespace battery_sof_simulator {

/**
 * @brief Has a file written that appears whole or not at all: `write` is given a name under which
 * it can be opened for writing.
 *
 * Where the file system can do that it has no name before, so that a process that is killed leaves
 * nothing behind; where a file is replaced it has one, PATH.PID.part, for the moment between naming
 * and renaming. Elsewhere it has that name throughout.
 * @throws std::runtime_error naming the path and the reason; nothing is left behind then.
 */
void writeWhole(const std::filesystem::path& path,
                const std::function<void(const std::filesystem::path&)>& write);

}  // namespace battery_sof_simulator
