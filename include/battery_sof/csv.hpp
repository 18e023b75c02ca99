#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "battery_sof/recording_error.hpp"
#include "battery_sof/series.hpp"

namespace battery_sof {

/// Names of the columns in the file's header line, and the file's sign of current.
struct CsvColumns {
  std::string time = "time_s";        ///< seconds, or UTC date and time "2017-03-25 07:00:06.900"
  std::string current = "current_a";  ///< [A]
  std::string voltage = "voltage_v";  ///< [V]
  /// [degC]; when not given, a column temperature_c is read if the file has one.
  std::optional<std::string> temperature;
  bool discharge_positive = false;  ///< the file counts current out of the battery as positive
  double time_unit = 1.0;           ///< [s], of which the time column counts; dates have none
  bool operator==(const CsvColumns& other) const {
    return std::tie(time, current, voltage, temperature, discharge_positive, time_unit) ==
           std::tie(other.time, other.current, other.voltage, other.temperature,
                    other.discharge_positive, other.time_unit);
  }
};

/// What is called with every block of bytes that was read, in order.
using BytesSeen = std::function<void(std::string_view)>;

/**
 * @brief Reads a recording from a comma-separated file, or a pipe, with a header line.
 *
 * Empty cells and NaN are missing values: such rows are counted, not used. Rows may carry a
 * temperature alone. Time is kept as written; dates become seconds since 1970-01-01 UTC. Cells may
 * be quoted and have spaces around them; a line break inside quotes is not understood. Blank lines,
 * a byte-order mark, CRLF, one trailing comma, comments (lines that begin with #) and a row of units
 * below the header are allowed. A last line with too few cells and no
 * line break was cut off while it was written: it counts as a missing value. The recording's name
 * is the file's, printable(). Numbers have a decimal point, whatever the locale, here and in
 * writeCsv. Where the header is separated by semicolons (it has one, and no column of the time's
 * name between commas), cells are too, and a number may have a decimal comma ("12,5"; not
 * "1.012,5").
 *
 * Cells may end with tabs, too. Where the package's own column name is asked for and the file does
 * not have it, the one column of a common name is read ("t", "Current (A)", "u" ...), the end of a
 * time column's name is its unit (ms, us, ns), and `notes` says so.
 *
 * @param seen is reported the bytes as they are read, all of them where nothing is thrown: a pipe
 * cannot be read again.
 * @param notes grows by what was assumed of the file; none: nobody wants to know.
 * @throws RecordingError when the file cannot be read, is no regular file or pipe, has a line that
 * is too long (TextLines), is empty, has a header only, lacks a column or has it twice, has a row
 * with more or fewer cells than the header (file and line are named), has text where a number
 * belongs (file, line, column and text are named), holds no usable sample, or when more than a
 * tenth of its samples go back in time (the file is not sorted).
 */
Recording readCsv(const std::filesystem::path& path, const CsvColumns& columns = {},
                  BytesSeen seen = {}, std::vector<std::string>* notes = nullptr);

/**
 * @brief Writes time_s,current_a,voltage_v and, when measured, temperature_c with the digits that
 * read back exactly.
 *
 * A temperature is written on the sample of the same time, or on a row of its own. The file appears
 * whole or not at all.
 * @throws RecordingError when the file cannot be written.
 */
void writeCsv(const std::filesystem::path& path, const Series& series);

/// @return the number in the fewest digits (15 to 17) that read back to the same double.
std::string formatExactly(double value);

}  // namespace battery_sof
