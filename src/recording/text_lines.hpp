#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "battery_sof/csv.hpp"

namespace battery_sof {

/**
 * @brief The lines of a text file or a pipe, read once and from its beginning to its end; a
 * byte-order mark is passed over.
 *
 * What is neither a regular file nor a pipe (a device, a folder, a socket) is refused before it is
 * opened. No more than one line is held at a time.
 */
class TextLines {
 public:
  /// [bytes] of a line: some fifty thousand numbers
  static constexpr std::size_t kLongest = 1 << 20;

  /// @throws RecordingError naming the file and why it cannot be read.
  explicit TextLines(const std::filesystem::path& path, BytesSeen seen = {});

  /// Goes on to the next line that is not blank. @return false at the end.
  /// @throws RecordingError when reading fails, or naming a line longer than kLongest.
  bool next();

  /// Without its line break; until the next next().
  std::string_view line() const { return line_; }
  std::size_t number() const { return number_; }
  /// False for a last line without a line break: the writer may have been cut off in it.
  bool finished() const { return finished_; }

 private:
  bool nextOfAny();

  std::filesystem::path path_;
  BytesSeen seen_;
  std::ifstream file_;
  std::vector<char> room_;
  std::string_view line_;  // of room_
  std::size_t number_ = 0;
  bool finished_ = true;
};

/// Puts the cells of a line into a list, without quotes and the spaces around them; separators
/// between quotes end none. They last as long as the line.
void splitCells(std::string_view line, char separator, std::vector<std::string_view>& cells);

}  // namespace battery_sof
