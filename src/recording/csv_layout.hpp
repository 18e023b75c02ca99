#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "battery_sof/csv.hpp"
#include "recording/csv_units.hpp"
#include "recording/text_lines.hpp"

namespace battery_sof {

constexpr std::size_t kNoColumn = std::numeric_limits<std::size_t>::max();

/// A column that is read.
struct Column {
  std::size_t index = kNoColumn;
  Unit unit = {"", 1.0};
  bool has_unit = false;  ///< an option, its name or a row of units says which
};

/// The header of a CSV file and which of its columns are read.
struct Layout {
  std::filesystem::path path;
  std::vector<std::string> names;
  char separator = ',';
  Column time, current, voltage, temperature;  ///< a profile has no voltage and no temperature
  bool time_unit_is_given = false;             ///< by an option, so that nothing else decides
  bool is_at_first_row = false;                ///< the header was a comment, and a row follows
};

/// Goes on to the next line that is neither blank nor a comment (#, %, //).
bool nextOfContent(TextLines& lines);

/**
 * @brief Reads the header: its separator, its columns and the units in their names.
 *
 * The header is the first line of content; where that is a row of numbers below a comment with as
 * many cells, the comment is.
 * @param is_profile without a voltage.
 * @param notes takes what was assumed.
 * @throws RecordingError as readCsv() does for a missing or ambiguous column.
 */
Layout readLayout(const std::filesystem::path& path, TextLines& lines, const CsvColumns& columns,
                  bool is_profile, std::vector<std::string>& notes);

/**
 * @brief Takes the units from the row below the header, if it is one: no cell of time, current or
 * voltage is a number, a date or empty.
 * @return whether it is.
 * @throws RecordingError naming line, column and text of a unit that is not known, or is another
 * than the one in the column's name.
 */
bool takeUnitsRow(Layout& layout, const std::vector<std::string_view>& cells, std::size_t line,
                  std::vector<std::string>& notes);

}  // namespace battery_sof
