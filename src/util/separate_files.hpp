#pragma once

#include <string>
#include <vector>

namespace battery_sof {

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
