#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "state/fitted_model.hpp"

namespace battery_sof {

/**
 * @brief The file in which the accepted model outlives the node.
 *
 * Read once, at the start. What cannot be used is set aside as FILE.refused (FILE.refused.1, .2 ...
 * where there is one), so that it is not read again and again; what is not a regular file (a device, a
 * pipe, a loop of links) is neither read, moved nor written. A symbolic link stays: the file that
 * it names is read, set aside and written, and may be missing. Nothing here throws or waits.
 */
class StateFile {
 public:
  /// @param path empty: the model is not kept.
  explicit StateFile(std::filesystem::path path) : path_(std::move(path)) {}

  /// What came of it, one sentence; `is_fault` when somebody should look.
  struct Result {
    std::string said = "";
    bool is_fault = false;
    std::optional<FittedModel> model = std::nullopt;  ///< that was read
  };

  /// @return without a model where there is no file, or it was refused.
  Result read() const;

  /// Writes the model whole or not at all, and only where read() would take it back.
  Result save(const FittedModel& model) const;

  /// Puts the file aside, under a name that is free. @return where it is now, or why it could not
  /// be moved.
  std::string setAside() const;

 private:
  std::filesystem::path path_;
};

}  // namespace battery_sof
