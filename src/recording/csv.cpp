#include "battery_sof/recording/csv.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "battery_sof/recording/atomic_file.hpp"
#include "battery_sof/recording/intake.hpp"
#include "battery_sof/recording/number_text.hpp"
#include "battery_sof/recording/sample_list.hpp"
#include "battery_sof/recording/words.hpp"

namespace battery_sof {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr double kZeroCelsius = 273.15;  // [K], definition of the degree Celsius
constexpr std::size_t kNoColumn = std::numeric_limits<std::size_t>::max();

// ---------------------------------------------------------------------------------------------
// text into cells

std::string readWholeFile(const std::filesystem::path& path) {
  std::error_code unreadable;
  if (std::filesystem::is_directory(path, unreadable)) {
    throw RecordingError(path.string() + ": is a directory, expected a CSV file");
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw RecordingError(path.string() + ": cannot be read: " + std::strerror(errno));
  }
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (file.bad()) throw RecordingError(path.string() + ": reading failed part-way");
  return text;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string_view unquoted(std::string_view cell) {
  cell = trimmed(cell);
  if (cell.size() < 2 || cell.front() != '"' || cell.back() != '"') return cell;
  return trimmed(cell.substr(1, cell.size() - 2));
}

/// Position of the separator that ends the cell beginning at first; those between quotes do not count.
std::size_t endOfCell(std::string_view line, std::size_t first, char separator) {
  bool quoted = false;
  for (std::size_t k = first; k < line.size(); ++k) {
    if (line[k] == '"') quoted = !quoted;
    if (line[k] == separator && !quoted) return k;
  }
  return line.size();
}

void splitCells(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  for (std::size_t first = 0; first <= line.size();) {
    const std::size_t last = endOfCell(line, first, separator);
    cells.push_back(unquoted(line.substr(first, last - first)));
    first = last + 1;
  }
}

/// The lines of a text, one at a time, with their numbers; blank lines are passed over.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (rest_.substr(0, kByteOrderMark.size()) == kByteOrderMark) {
      rest_.remove_prefix(kByteOrderMark.size());
    }
  }

  bool next() {
    while (!rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      finished_ = end != std::string_view::npos;
      line_ = rest_.substr(0, end);
      rest_.remove_prefix(finished_ ? end + 1 : rest_.size());
      ++number_;
      if (!trimmed(line_).empty()) return true;
    }
    return false;
  }

  std::string_view line() const { return line_; }
  std::size_t number() const { return number_; }
  /// False for a last line without a line break: the writer may have been cut off in it.
  bool finished() const { return finished_; }

 private:
  std::string_view rest_, line_;
  std::size_t number_ = 0;
  bool finished_ = true;
};

// ---------------------------------------------------------------------------------------------
// header

/// The header line and which of its columns are read.
struct Layout {
  std::filesystem::path path;
  std::vector<std::string_view> names;
  char separator = ',';
  std::size_t time = 0, current = 0, voltage = 0, temperature = kNoColumn;
};

std::string separatorHint(const Layout& layout) {
  if (layout.names.size() != 1) return "";
  const bool other = layout.names.front().find_first_of("|\t") != std::string_view::npos;
  return other ? "; the file does not look comma-separated" : "";
}

std::size_t columnIndex(const Layout& layout, const std::string& name) {
  const auto first = std::find(layout.names.begin(), layout.names.end(), name);
  if (first == layout.names.end()) {
    throw RecordingError(layout.path.string() + ": has no column \"" + name + "\"; its columns are: " + listed(layout.names) +
                         separatorHint(layout));
  }
  if (std::find(first + 1, layout.names.end(), name) != layout.names.end()) {
    throw RecordingError(layout.path.string() + ": has column \"" + name + "\" more than once; its columns are: " + listed(layout.names));
  }
  return first - layout.names.begin();
}

Layout readLayout(const std::filesystem::path& path, Lines& lines, const CsvColumns& columns) {
  if (!lines.next()) {
    throw RecordingError(path.string() + ": is empty, expected a header line with the columns " + columns.time + ", " + columns.current +
                         ", " + columns.voltage);
  }
  Layout layout{path, {}};
  splitCells(lines.line(), layout.separator, layout.names);
  const bool has_time = std::find(layout.names.begin(), layout.names.end(), columns.time) != layout.names.end();
  if (!has_time && endOfCell(lines.line(), 0, ';') < lines.line().size()) {
    layout.separator = ';';
    splitCells(lines.line(), layout.separator, layout.names);
  }
  layout.time = columnIndex(layout, columns.time);
  layout.current = columnIndex(layout, columns.current);
  layout.voltage = columnIndex(layout, columns.voltage);
  const std::string temperature = columns.temperature.value_or("temperature_c");
  const auto found = std::find(layout.names.begin(), layout.names.end(), temperature);
  if (columns.temperature || found != layout.names.end()) {
    layout.temperature = columnIndex(layout, temperature);
  }
  return layout;
}

// ---------------------------------------------------------------------------------------------
// cells into numbers

/// Where cells end with semicolons, a single comma without a point beside it is the decimal sign.
std::string withPoint(std::string_view cell, char separator) {
  std::string text(cell);
  const std::size_t comma = text.find(',');
  const bool is_decimal = separator == ';' && comma != std::string::npos && text.find_first_of(",.", comma + 1) == std::string::npos &&
                          text.find('.') == std::string::npos;
  if (is_decimal) text[comma] = '.';
  return text;
}

/// The whole cell as a number, NaN for an empty one; nothing when it is text.
std::optional<double> parseNumber(std::string_view cell) { return cell.empty() ? kMissing : numberOf(cell); }

/// Days from 1970-01-01 to a date of the Gregorian calendar; nothing for a date it does not have.
std::optional<double> daysSinceEpoch(int year, int month, int day) {
  std::tm date{};
  date.tm_year = year - 1900;
  date.tm_mon = month - 1;
  date.tm_mday = day;
  const std::time_t seconds = timegm(&date);  // makes 3 March of 31 February
  if (date.tm_mon != month - 1 || date.tm_mday != day) return std::nullopt;
  return static_cast<double>(seconds) / 86400.0;
}

/// "2017-03-25 07:00:06.900", with T for the space and with a closing Z too, as seconds since
/// 1970-01-01 UTC.
std::optional<double> parseDateTime(std::string_view cell) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, used = 0;
  char separator = 0;
  const std::string text(cell.back() == 'Z' ? cell.substr(0, cell.size() - 1) : cell);
  const int read = std::sscanf(text.c_str(), "%4d-%2d-%2d%c%2d:%2d:%n", &year, &month, &day, &separator, &hour, &minute, &used);
  if (read != 6 || used == 0 || (separator != ' ' && separator != 'T')) return std::nullopt;
  const std::optional<double> second = parseNumber(std::string_view(text).substr(used));
  const std::optional<double> days = daysSinceEpoch(year, month, day);
  const bool valid = days && hour >= 0 && hour <= 24 && minute >= 0 && minute <= 59 && second && *second >= 0.0 && *second < 61.0;
  if (!valid) return std::nullopt;
  return 86400.0 * *days + 3600.0 * hour + 60.0 * minute + *second;
}

/// One row of the file, whose faults are reported with their place.
struct Row {
  const Layout& layout;
  const std::vector<std::string_view>& cells;
  std::size_t line;

  [[noreturn]] void refuse(std::size_t column, const std::string& expected) const {
    throw RecordingError(layout.path.string() + ", line " + std::to_string(line) + ", column \"" + std::string(layout.names[column]) +
                         "\": \"" + std::string(cells[column]) + "\" is not " + expected);
  }

  double number(std::size_t column) const {
    const std::optional<double> value = parseNumber(withPoint(cells[column], layout.separator));
    if (!value) refuse(column, "a number");
    return *value;
  }

  double time() const {
    const std::string text = withPoint(cells[layout.time], layout.separator);
    if (const auto seconds = parseNumber(text)) return *seconds;
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
  RawSample sample;
  sample.time = row.time();
  sample.current = sign * row.number(row.layout.current);
  sample.voltage = row.number(row.layout.voltage);
  sample.temperature = row.temperature();
  return sample;
}

void requireWholeRow(const Row& row) {
  const std::size_t expected = row.layout.names.size(), found = row.cells.size();
  const bool trailing_comma = found == expected + 1 && row.cells.back().empty();
  if (found == expected || trailing_comma) return;
  throw RecordingError(row.layout.path.string() + ", line " + std::to_string(row.line) + ": has " + std::to_string(found) +
                       " cells, the header has " + std::to_string(expected));
}

void readRows(Lines& lines, const Layout& layout, const CsvColumns& columns, Recording& recording) {
  constexpr RawSample kCutOff{kMissing, kMissing, kMissing, std::nullopt};
  Intake intake;
  std::vector<std::string_view> cells;
  while (lines.next()) {
    splitCells(lines.line(), layout.separator, cells);
    const Row row{layout, cells, lines.number()};
    if (!lines.finished() && cells.size() < layout.names.size()) {
      append(recording, intake, kCutOff);
      return;
    }
    requireWholeRow(row);
    append(recording, intake, toSample(row, columns));
  }
}

// --------------------------------------------------------------------------------------------- the
// whole file

void requireSamples(const std::filesystem::path& path, const Recording& recording) {
  if (recording.offered == 0) {
    throw RecordingError(path.string() + ": has a header line but no sample below it");
  }
  requireUsable(path.string(), recording);
}

/// Fewest digits whose value satisfies is_exact; 17 always tell two doubles apart.
template <typename Exact>
void appendDigits(std::string& text, double value, Exact is_exact) {
  std::string number;
  for (int digits = 15; digits <= 17; ++digits) {
    number = sentence("%.*g", digits, value);
    if (is_exact(*numberOf(number))) break;
  }
  text += number;
}

void appendNumber(std::string& text, double value) {
  appendDigits(text, value, [value](double read) { return read == value; });
}

void appendCelsius(std::string& text, double kelvin) {
  appendDigits(text, kelvin - kZeroCelsius, [kelvin](double read) { return read + kZeroCelsius == kelvin; });
}

/// Writes series in order of time, merging the samples with the temperatures' own time base.
class CsvWriter {
 public:
  explicit CsvWriter(const Series& series) : series_(series), warm_(!series.temperature.empty()) {}

  std::string text() {
    text_ = "time_s,current_a,voltage_v";
    text_ += warm_ ? ",temperature_c\n" : "\n";
    while (sample_ < series_.size() || temperature_ < series_.temperature.size()) writeRow();
    return std::move(text_);
  }

 private:
  static double timeOf(const std::vector<double>& time, std::size_t k) {
    return k < time.size() ? time[k] : std::numeric_limits<double>::infinity();
  }

  void writeRow() {
    const double sample_time = timeOf(series_.time, sample_);
    const double temperature_time = timeOf(series_.temperature_time, temperature_);
    appendNumber(text_, std::min(sample_time, temperature_time));
    writeSample(sample_time <= temperature_time);
    if (warm_) writeTemperature(temperature_time <= sample_time);
    text_ += '\n';
  }

  void writeSample(bool present) {
    text_ += ',';
    if (present) appendNumber(text_, series_.current[sample_]);
    text_ += ',';
    if (present) appendNumber(text_, series_.voltage[sample_++]);
  }

  void writeTemperature(bool present) {
    text_ += ',';
    if (present) appendCelsius(text_, series_.temperature[temperature_++]);
  }

  const Series& series_;
  bool warm_;
  std::size_t sample_ = 0, temperature_ = 0;
  std::string text_;
};

}  // namespace

std::string formatExactly(double value) {
  std::string text;
  appendNumber(text, value);
  return text;
}

Recording readCsv(const std::filesystem::path& path, const CsvColumns& columns) {
  const std::string text = readWholeFile(path);
  Lines lines(text);
  const Layout layout = readLayout(path, lines, columns);
  Recording recording;
  recording.name = path.filename().string();
  readRows(lines, layout, columns, recording);
  requireSamples(path, recording);
  return recording;
}

void writeCsv(const std::filesystem::path& path, const Series& series) {
  try {
    writeFileAtomically(path, CsvWriter(series).text());
  } catch (const std::runtime_error& error) {
    throw RecordingError(error.what());
  }
}

}  // namespace battery_sof
