#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace battery_sof {

/// Whether a file is the log of a CAN bus, by its first bytes: BLF, MF4, and ASC by its name too. A
/// pipe is not looked into.
bool isCanLog(const std::string& path);

/// What to do with such a file, as a sentence of an error.
std::string canLogAdvice(const std::string& path);

/// Signals of a CAN log, as the DBC file names them.
struct CanSignals {
  std::string dbc;  ///< file
  std::string current, voltage;
  std::optional<std::string> temperature;
  bool discharge_positive = false;
};

/**
 * @brief A CAN log as a CSV file in a temporary folder, which is gone with this object.
 *
 * The program can_log makes it: a script of this package in Python, which needs python3-can. It is
 * looked for beside the running program, then on the PATH.
 */
class CanLogAsCsv {
 public:
  /// @throws RecordingError naming the log, and what can_log says or that it cannot be run.
  CanLogAsCsv(const std::string& log, const CanSignals& signals);
  ~CanLogAsCsv();
  CanLogAsCsv(const CanLogAsCsv&) = delete;
  CanLogAsCsv& operator=(const CanLogAsCsv&) = delete;

  std::string path() const { return (folder_ / name_).string(); }

 private:
  std::filesystem::path folder_;
  std::string name_;
};

}  // namespace battery_sof
