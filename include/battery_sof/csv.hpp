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

/// The names of the columns in the header line of the file, and its sign of the current.
struct CsvColumns {
  std::string time = "time_s";        ///< a count, or date and time "2017-03-25 07:00:06.900"
  std::string current = "current_a";  ///< [A], unless the file says mA or kA
  std::string voltage = "voltage_v";  ///< [V], unless the file says mV
  /// [degC], unless the file says K; when not given, a column temperature_c is read if it has one.
  std::optional<std::string> temperature;
  bool discharge_positive = false;  ///< the file counts current out of the battery as positive
  /// [s], unit of the time column; dates ignore it. If it is not given, the unit is that of the
  /// column's name or of the row of units, or else a second.
  std::optional<double> time_unit = std::nullopt;
  bool operator==(const CsvColumns& other) const {
    return std::tie(time, current, voltage, temperature, discharge_positive, time_unit) ==
           std::tie(other.time, other.current, other.voltage, other.temperature,
                    other.discharge_positive, other.time_unit);
  }
};

/// Callback that receives every block of bytes as it is read, in order.
using BytesSeen = std::function<void(std::string_view)>;

/**
 * @brief Reads a recording from a comma-separated file, or a pipe, with a header line.
 *
 * Empty cells and NaN are missing values. Rows with a missing current or voltage are counted but
 * not used; a row may have a temperature alone. Time is kept as written, and dates become seconds
 * since 1970-01-01 UTC. Cells may be quoted and have spaces around them, but a line break inside
 * quotes is not supported. Blank lines, comments (lines that begin with #, % or //), a byte-order
 * mark, CRLF and one trailing comma are allowed. A comment directly above a row of as many numbers
 * is the header. Dates are in UTC, or have an offset from it (+01:00, -0500, +01).
 * A last line with too few cells and no line break was cut off while it was written, so it counts
 * as a missing value. The recording is named after the file, printable(). Numbers have a decimal
 * point, whatever the locale, here and in writeCsv. If the header is separated by semicolons (it
 * has one, and no column of the time's name between commas) or by tabs, so are the cells, and a
 * number may have a decimal comma ("12,5", but not "1.012,5").
 *
 * If the package's own column name is asked for and the file does not have it, the one column with
 * a common name is read ("t", "Current (A)", "u" ...). Units are those at the end of a column's name
 * ("Current [mA]", "time_ms") or of a row of units below the header: s, ms, us, ns, min, h; A, mA,
 * kA; V, mV; degC, C, K. Times that count from 1970 are recognised by their size, in s, ms, us or ns
 * of the years 2001 to 2099, unless a unit is given; they become seconds since 1970, as dates do.
 * `notes` says what was assumed, also that of seconds which nothing names, where rows are 1 s or
 * more apart: they may be milliseconds.
 *
 * @param seen receives the bytes as they are read, and all of them if nothing is thrown, because a
 * pipe cannot be read again.
 * @param notes receives a sentence for everything that was assumed of the file; may be null.
 * @throws RecordingError if the file cannot be read, is neither a regular file nor a pipe, has a
 * line that is too long (TextLines), is empty, has only a header, lacks a column or has it twice,
 * has a row with more or fewer cells than the header (the message names file and line), has text in
 * place of a number or of a known unit (the message names file, line, column and text), has a row of
 * units that contradicts a column's name, or contains no usable sample.
 * It is also thrown if more than a tenth of the samples go back in time, since such a file is not
 * sorted.
 */
Recording readCsv(const std::filesystem::path& path, const CsvColumns& columns = {},
                  BytesSeen seen = {}, std::vector<std::string>* notes = nullptr);

/// Receives a row's time [s] and current [A], and its number in the file.
using ProfileRowSeen = std::function<void(double time, double current, std::size_t line)>;

/**
 * @brief Reads a current over time. The file may have the same names, separators, units and dates
 * as a recording for readCsv(), but it needs no voltage.
 *
 * Times that count from 1970 become seconds after the first row. Other columns are ignored.
 * @param row receives every row in order; a cell without a number is NaN.
 * @throws RecordingError as readCsv() does.
 */
void readProfileCsv(const std::filesystem::path& path, const CsvColumns& columns,
                    const ProfileRowSeen& row, std::vector<std::string>* notes = nullptr);

/**
 * @brief Writes time_s,current_a,voltage_v and, if measured, temperature_c, with as many digits as
 * reading them back exactly needs.
 *
 * A temperature is written in the row of the sample with the same time, or in a row of its own. The
 * file appears whole or not at all.
 * @throws RecordingError when the file cannot be written.
 */
void writeCsv(const std::filesystem::path& path, const Series& series);

/// @return the number in the fewest digits (15 to 17) that read back to the same double.
std::string formatExactly(double value);

}  // namespace battery_sof
