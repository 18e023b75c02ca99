#include "battery_sof/csv.hpp"

#include "recording/text_lines.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "battery_sof/intake.hpp"
#include "battery_sof/sample_list.hpp"
#include "util/constants.hpp"
#include "util/files.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kEpochFirst = 978307200.0, kEpochLast = 4102444800.0;  // [s], 2001 to 2099
constexpr std::size_t kNoColumn = std::numeric_limits<std::size_t>::max();

// ---------------------------------------------------------------------------------------------
// header

/// The header line and which of its columns are read.
struct Layout {
  std::filesystem::path path;
  std::vector<std::string> names;
  char separator = ',';
  std::size_t time = 0, current = 0;
  std::size_t voltage = kNoColumn, temperature = kNoColumn;  ///< a profile has none
  double time_unit = 1.0;                                    ///< [s]
  bool unit_is_given = false;
};

std::string separatorHint(const Layout& layout) {
  if (layout.names.size() != 1) return "";
  if (layout.names.front().rfind("#ROSBAG", 0) == 0)
    return "; this is a bag, which is read from a file, not from a pipe";
  const bool other = layout.names.front().find_first_of("|\t") != std::string::npos;
  return other ? "; the file does not look comma-separated" : "";
}

/// @param remedy what to do where the column is missing.
std::size_t columnIndex(const Layout& layout, const std::string& name,
                        const std::string& remedy = "") {
  const auto first = std::find(layout.names.begin(), layout.names.end(), name);
  if (first == layout.names.end())
    throw RecordingError(layout.path.string() + ": has no column \"" + shortened(name) +
                         "\"; its columns are: " + someOf(layout.names) +
                         (layout.names.size() == 1 ? separatorHint(layout) : remedy));
  if (std::find(first + 1, layout.names.end(), name) != layout.names.end())
    throw RecordingError(layout.path.string() + ": has column \"" + shortened(name) +
                         "\" more than once; its columns are: " + someOf(layout.names));
  return first - layout.names.begin();
}

/// Common names of a column, without case, spaces and punctuation: "Current [A]" is "currenta".
struct CommonNames {
  const char* meaning;
  const char* option;
  std::vector<std::string> names;
};
const CommonNames kTimes{
    "time",
    "--time-column",
    {"times",        "time",        "ts",         "t",      "seconds",     "sec",         "timesec",
     "elapsedtimes", "timestamp",   "timestamps", "timems", "tms",         "timestampms", "timeus",
     "tus",          "timestampus", "timens",     "tns",    "timestampns", "testtimes"}};
const CommonNames kCurrents{"current",
                            "--current-column",
                            {"currenta", "current", "ia", "i", "amps", "ampere", "ibat", "ibata",
                             "ibatt", "batterycurrent", "batterycurrenta"}};
const CommonNames kVoltages{
    "voltage",
    "--voltage-column",
    {"voltagev", "voltage", "uv", "vv", "u", "v", "volts", "volt", "vbat", "vbatt", "ubat", "ubatt",
     "vbatv", "ubatv", "batteryvoltage", "batteryvoltagev"}};
const CommonNames kTemperatures{"temperature",
                                "--temperature-column",
                                {"temperaturec", "tempc", "temperaturedegc", "tempdegc",
                                 "temperature", "temp", "batterytempc", "batterytemperaturec"}};

std::string bareName(const std::string& name) {
  std::string bare;
  for (const unsigned char letter : name)
    if (std::isalnum(letter)) bare += static_cast<char>(std::tolower(letter));
  return bare;
}

std::vector<std::string> commonlyNamed(const Layout& layout, const CommonNames& common) {
  std::vector<std::string> found;
  for (const std::string& name : layout.names)
    if (contains(common.names, bareName(name))) found.push_back(name);
  return found;
}

/// The column that was asked for; where that is the package's own name and the file does not have
/// it, the one column of a common name.
std::size_t columnOf(const Layout& layout, const std::string& name, const std::string& own_name,
                     const CommonNames& common, std::vector<std::string>& notes) {
  if (name != own_name || contains(layout.names, name)) return columnIndex(layout, name);
  const std::vector<std::string> found = commonlyNamed(layout, common);
  if (found.size() > 1)
    throw RecordingError(layout.path.string() + ": has no column \"" + name + "\", and " +
                         someOf(found) + " may be the " + common.meaning + ": name one with " +
                         common.option);
  if (found.empty())
    return columnIndex(
        layout, name,
        std::string("; name that of the ") + common.meaning + " with " + common.option);
  notes.push_back(std::string(common.meaning) + " is read from column \"" + found.front() + "\"");
  return columnIndex(layout, found.front());
}

/// Unit of a time column by the end of its name [s]; 1 where that says nothing.
double unitInName(const std::string& name) {
  const std::string bare = bareName(name);
  for (const auto& [end, unit] :
       {std::pair<const char*, double>{"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}})
    if (bare.size() > 2 && bare.compare(bare.size() - 2, 2, end) == 0) return unit;
  return 1.0;
}

std::vector<std::string> namesIn(std::string_view header, char separator) {
  std::vector<std::string_view> cells;
  splitCells(header, separator, cells);
  return {cells.begin(), cells.end()};
}

/// Goes on to the next line that is no comment.
bool nextOfContent(TextLines& lines) {
  while (lines.next())
    if (lines.line().front() != '#' || lines.line().rfind("#ROSBAG", 0) == 0) return true;
  return false;
}

/// @param is_profile without a voltage.
Layout readLayout(const std::filesystem::path& path, TextLines& lines, const CsvColumns& columns,
                  bool is_profile, std::vector<std::string>& notes) {
  if (!nextOfContent(lines))
    throw RecordingError(path.string() + ": is empty, expected a header line with the columns " +
                         columns.time + ", " + columns.current +
                         (is_profile ? "" : ", " + columns.voltage));
  Layout layout{path, namesIn(lines.line(), ',')};
  for (const char separator : {';', '\t'}) {
    if (contains(layout.names, columns.time)) break;
    std::vector<std::string> names = namesIn(lines.line(), separator);
    if (names.size() > layout.names.size() || contains(names, columns.time))
      layout.separator = separator, layout.names = std::move(names);
  }
  const CsvColumns own;
  layout.time = columnOf(layout, columns.time, own.time, kTimes, notes);
  layout.current = columnOf(layout, columns.current, own.current, kCurrents, notes);
  if (!is_profile)
    layout.voltage = columnOf(layout, columns.voltage, own.voltage, kVoltages, notes);
  layout.unit_is_given = columns.time_unit.has_value();
  layout.time_unit = columns.time_unit.value_or(1.0);
  if (!columns.time_unit && columns.time == own.time) {
    layout.time_unit = unitInName(layout.names[layout.time]);
    if (layout.time_unit != 1.0)
      notes.push_back(
          format("time is taken to count %g s, by its column's name", layout.time_unit));
  }
  if (is_profile) return layout;
  const std::string temperature = columns.temperature.value_or("temperature_c");
  if (columns.temperature || contains(layout.names, temperature))
    layout.temperature = columnIndex(layout, temperature);
  else if (const auto common = commonlyNamed(layout, kTemperatures); common.size() == 1)
    layout.temperature = columnOf(layout, temperature, "temperature_c", kTemperatures, notes);
  return layout;
}

/// Whether a row below the header names units: no cell that is read is a number, a date or empty.
bool isUnitsRow(const Layout& layout, const std::vector<std::string_view>& cells) {
  if (cells.size() < layout.names.size()) return false;
  for (const std::size_t column : {layout.time, layout.current, layout.voltage}) {
    if (column == kNoColumn) continue;
    const std::string unit = bareName(std::string(cells[column]));
    if (unit.empty() || unit.size() > 4 ||
        !std::all_of(unit.begin(), unit.end(),
                     [](unsigned char c) { return std::isalpha(c) != 0; }) ||
        unit == "nan" || unit == "inf")
      return false;
  }
  return true;
}

// ---------------------------------------------------------------------------------------------
// cells into numbers

/// Where cells end with semicolons, a single comma without a point next to it is the decimal sign.
std::string withPoint(std::string_view cell, char separator) {
  std::string text(cell);
  const std::size_t comma = text.find(',');
  const bool is_decimal = separator == ';' && comma != std::string::npos &&
                          text.find_first_of(",.", comma + 1) == std::string::npos &&
                          text.find('.') == std::string::npos;
  if (is_decimal) text[comma] = '.';
  return text;
}

/// The whole cell as a number, NaN for an empty one; nothing when it is text.
std::optional<double> parseNumber(std::string_view cell) {
  return cell.empty() ? kNan : numberOf(cell);
}

/// "2017-03-25 07:00:06.900", with T for the space and with a closing Z too, as seconds since
/// 1970-01-01 UTC.
std::optional<double> parseDateTime(std::string_view cell) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, used = 0;
  char separator = 0;
  const std::string text(cell.back() == 'Z' ? cell.substr(0, cell.size() - 1) : cell);
  const int read = std::sscanf(text.c_str(), "%4d-%2d-%2d%c%2d:%2d:%n", &year, &month, &day,
                               &separator, &hour, &minute, &used);
  if (read != 6 || used == 0 || (separator != ' ' && separator != 'T')) return std::nullopt;
  const std::optional<double> second = parseNumber(std::string_view(text).substr(used));
  std::tm date{};
  date.tm_year = year - 1900;
  date.tm_mon = month - 1;
  date.tm_mday = day;
  const double days = static_cast<double>(timegm(&date)) / 86400.0;  // makes 3 March of 31 February
  const bool is_date = date.tm_mon == month - 1 && date.tm_mday == day;
  const bool valid = is_date && hour >= 0 && minute >= 0 && minute <= 59 && second &&
                     *second >= 0.0 && *second < 61.0 &&
                     (hour < 24 || (hour == 24 && minute == 0 && *second == 0.0));
  if (!valid) return std::nullopt;
  return 86400.0 * days + 3600.0 * hour + 60.0 * minute + *second;
}

/// One row of the file, whose faults are reported with their place.
struct Row {
  const Layout& layout;
  const std::vector<std::string_view>& cells;
  std::size_t line;

  [[noreturn]] void refuse(std::size_t column, const std::string& expected) const {
    throw RecordingError(layout.path.string() + ", line " + std::to_string(line) + ", column \"" +
                         shortened(layout.names[column]) + "\": \"" + shortened(cells[column]) +
                         "\" is not " + expected);
  }

  double number(std::size_t column) const {
    const std::optional<double> value = parseNumber(withPoint(cells[column], layout.separator));
    if (!value) refuse(column, "a number");
    return *value;
  }

  /// @param unit [s], of a number.
  double time(double unit) const {
    const std::string text = withPoint(cells[layout.time], layout.separator);
    if (const auto number = parseNumber(text)) return unit * *number;
    if (const auto seconds = parseDateTime(text)) return *seconds;
    refuse(layout.time, "a number of seconds or a date and time like 2017-03-25 07:00:06.900");
  }

  std::optional<double> temperature() const {
    if (layout.temperature == kNoColumn) return std::nullopt;
    const double celsius = number(layout.temperature);
    return std::isnan(celsius) ? std::nullopt : std::optional(celsius + kZeroCelsius);
  }
};

RawSample toSample(const Row& row, const CsvColumns& columns) {
  const double sign = columns.discharge_positive ? -1.0 : 1.0;
  return {row.time(row.layout.time_unit), sign * row.number(row.layout.current),
          row.layout.voltage == kNoColumn ? kNan : row.number(row.layout.voltage),
          row.temperature()};
}

void requireWholeRow(const Row& row) {
  const std::size_t expected = row.layout.names.size(), found = row.cells.size();
  const bool trailing_comma = found == expected + 1 && row.cells.back().empty();
  if (found == expected || trailing_comma) return;
  throw RecordingError(row.layout.path.string() + ", line " + std::to_string(row.line) + ": has " +
                       std::to_string(found) + " cells, the header has " +
                       std::to_string(expected));
}

/// What a time counts that must count from 1970 [s]: its size fits the years 2001 to 2099 in one
/// unit alone. None for a clock of another kind.
std::optional<double> epochUnit(double time) {
  for (const double unit : {1.0, 1e-3, 1e-6, 1e-9})
    if (time * unit >= kEpochFirst && time * unit < kEpochLast) return unit;
  return std::nullopt;
}

/// "2023-11-14 22:13:20 UTC".
std::string dateText(double seconds) {
  const auto whole = static_cast<std::time_t>(std::floor(seconds));
  std::tm date{};
  gmtime_r(&whole, &date);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S UTC", &date);
  return text.data();
}

/// Takes the unit of a clock that counts from 1970 from its first time, where nobody gave one.
/// @return whether it is such a clock.
bool takeEpochUnit(Layout& layout, std::string_view cell, std::vector<std::string>& notes) {
  const auto first = cell.empty() ? std::nullopt : numberOf(withPoint(cell, layout.separator));
  if (!first || layout.unit_is_given) return false;
  const std::optional<double> unit = epochUnit(*first);
  // What the column's name says holds while it makes a time that a logger's clock may show.
  const bool is_named = layout.time_unit != 1.0 && *first * layout.time_unit < kEpochFirst;
  if (!unit || is_named) return false;
  layout.time_unit = *unit;
  const char* name = *unit == 1.0    ? "seconds"
                     : *unit == 1e-3 ? "milliseconds"
                     : *unit == 1e-6 ? "microseconds"
                                     : "nanoseconds";
  notes.push_back(
      format("time is taken to count %s since 1970, by its size: the first row is of ", name) +
      dateText(*unit * *first));
  return true;
}

/// @param take (const RawSample&, line) of every row; a row that was cut off has no number.
/// @return whether the clock counts from 1970.
template <typename Take>
bool readRows(TextLines& lines, Layout layout, const CsvColumns& columns,
              std::vector<std::string>& notes, Take&& take) {
  constexpr RawSample kCutOff{kNan, kNan, kNan, std::nullopt};
  std::vector<std::string_view> cells;
  bool is_epoch = false, has_clock = false;
  bool is_first = true;
  while (nextOfContent(lines)) {
    splitCells(lines.line(), layout.separator, cells);
    if (std::exchange(is_first, false) && isUnitsRow(layout, cells)) continue;
    const Row row{layout, cells, lines.number()};
    if (!lines.finished() && cells.size() < layout.names.size()) {
      take(kCutOff, lines.number());
      break;
    }
    requireWholeRow(row);
    if (!has_clock && !cells[layout.time].empty()) {
      is_epoch = takeEpochUnit(layout, cells[layout.time], notes);
      has_clock = true;
    }
    take(toSample(row, columns), lines.number());
  }
  return is_epoch;
}

// ---------------------------------------------------------------------------------------------
// the whole file

/// Fewest digits whose value satisfies is_exact; 17 always tell two doubles apart.
template <typename Exact>
std::string digitsOf(double value, Exact is_exact) {
  std::string number;
  for (int digits = 15; digits <= 17; ++digits) {
    number = format("%.*g", digits, value);
    if (is_exact(*numberOf(number))) break;
  }
  return number;
}

std::string csvOf(const Series& series) {
  const bool is_warm = !series.temperature.empty();
  const auto cell = [](double value) {
    return std::isnan(value) ? std::string() : formatExactly(value);
  };
  std::string text = "time_s,current_a,voltage_v";
  text += is_warm ? ",temperature_c\n" : "\n";
  for (const RawSample& sample : rawSamplesOf(series)) {
    text += formatExactly(sample.time) + "," + cell(sample.current) + "," + cell(sample.voltage);
    if (is_warm) text += ",";
    if (sample.temperature)
      text += digitsOf(*sample.temperature - kZeroCelsius,
                       [&](double read) { return read + kZeroCelsius == *sample.temperature; });
    text += '\n';
  }
  return text;
}

}  // namespace

std::string formatExactly(double value) {
  return digitsOf(value, [value](double read) { return read == value; });
}

Recording readCsv(const std::filesystem::path& path, const CsvColumns& columns, BytesSeen seen,
                  std::vector<std::string>* notes) {
  TextLines lines(path, std::move(seen));
  std::vector<std::string> assumed;
  if (!notes) notes = &assumed;
  const Layout layout = readLayout(path, lines, columns, false, *notes);
  Recording recording;
  recording.name = printable(path.filename().string());
  Intake intake;
  readRows(lines, layout, columns, *notes,
           [&](const RawSample& sample, std::size_t) { append(recording, intake, sample); });
  if (recording.offered == 0)
    throw RecordingError(path.string() + ": has a header line but no sample below it");
  requireUsable(path.string(), recording);
  return recording;
}

void readProfileCsv(const std::filesystem::path& path, const CsvColumns& columns,
                    const ProfileRowSeen& row, std::vector<std::string>* notes) {
  TextLines lines(path);
  std::vector<std::string> assumed;
  if (!notes) notes = &assumed;
  const Layout layout = readLayout(path, lines, columns, true, *notes);
  bool has_rows = false;
  std::optional<double> origin;
  readRows(lines, layout, columns, *notes, [&](const RawSample& sample, std::size_t line) {
    // A date, or a count from 1970, is no time after the beginning of a phase.
    if (!origin) origin = epochUnit(sample.time) == 1.0 ? sample.time : 0.0;
    row(sample.time - *origin, sample.current, line);
    has_rows = true;
  });
  if (!has_rows) throw RecordingError(path.string() + ": has a header line but no row below it");
}

void writeCsv(const std::filesystem::path& path, const Series& series) {
  try {
    writeFileAtomically(path, csvOf(series));
  } catch (const std::runtime_error& error) {
    throw RecordingError(error.what());
  }
}

}  // namespace battery_sof
