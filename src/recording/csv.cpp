#include "battery_sof/csv.hpp"

#include <array>
#include <cmath>
#include <ctime>
#include <string_view>
#include <utility>
#include <vector>

#include "battery_sof/intake.hpp"
#include "battery_sof/sample_list.hpp"
#include "recording/channel_statistics.hpp"
#include "recording/csv_cells.hpp"
#include "recording/csv_layout.hpp"
#include "util/constants.hpp"
#include "util/files.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kEpochFirst = 978307200.0, kEpochLast = 4102444800.0;  // [s], 2001 to 2099
constexpr double kTellingInterval = 1.0;  // [s]; milliseconds are at least that if read as seconds

// ---------------------------------------------------------------------------------------------
// rows

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

  double time() const {
    const std::string text = withPoint(cells[layout.time.index], layout.separator);
    if (const auto number = parseNumber(text)) return layout.time.unit.scale * *number;
    if (const auto seconds = parseDateTime(text)) return *seconds;
    refuse(layout.time.index,
           "a number of seconds or a date and time like 2017-03-25 07:00:06.900 (UTC, or with an "
           "offset: +01:00)");
  }

  /// NaN where there is no such column.
  double value(const Column& column) const {
    return column.index == kNoColumn ? kNan : column.unit.scale * number(column.index);
  }

  std::optional<double> temperature() const {
    const double above_offset = value(layout.temperature);
    return std::isnan(above_offset) ? std::nullopt
                                    : std::optional(above_offset + layout.temperature.unit.offset);
  }
};

RawSample toSample(const Row& row, const CsvColumns& columns) {
  const double sign = columns.discharge_positive ? -1.0 : 1.0;
  return {row.time(), sign * row.value(row.layout.current), row.value(row.layout.voltage),
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

/// Takes the unit of a clock that counts from 1970 from its first time, where nobody gave one. Dates
/// need none.
void takeEpochUnit(Layout& layout, std::string_view cell, std::vector<std::string>& notes) {
  const auto first = numberOf(withPoint(cell, layout.separator));
  if (!first) layout.time.has_unit = true;
  if (!first || layout.time_unit_is_given) return;
  const std::optional<double> unit = epochUnit(*first);
  // What the column's name says holds while it makes a time that a logger's clock may show.
  const double named = layout.time.unit.scale;
  const bool is_named = named != 1.0 && *first * named < kEpochFirst;
  if (!unit || is_named) return;
  layout.time.unit.scale = *unit;
  layout.time.has_unit = true;
  const char* name = *unit == 1.0    ? "seconds"
                     : *unit == 1e-3 ? "milliseconds"
                     : *unit == 1e-6 ? "microseconds"
                                     : "nanoseconds";
  notes.push_back(
      format("time is taken to count %s since 1970, by its size: the first row is of ", name) +
      dateText(*unit * *first));
}

/// @param take (const RawSample&, line) of every row; a row that was cut off has no number.
template <typename Take>
void readRows(TextLines& lines, Layout& layout, const CsvColumns& columns,
              std::vector<std::string>& notes, Take&& take) {
  constexpr RawSample kCutOff{kNan, kNan, kNan, std::nullopt};
  std::vector<std::string_view> cells;
  bool has_clock = false, is_first = true;
  while (std::exchange(layout.is_at_first_row, false) || nextOfContent(lines)) {
    splitCells(lines.line(), layout.separator, cells);
    if (std::exchange(is_first, false) && takeUnitsRow(layout, cells, lines.number(), notes))
      continue;
    const Row row{layout, cells, lines.number()};
    if (!lines.finished() && cells.size() < layout.names.size()) {
      take(kCutOff, lines.number());
      break;
    }
    requireWholeRow(row);
    if (!has_clock && !cells[layout.time.index].empty()) {
      takeEpochUnit(layout, cells[layout.time.index], notes);
      has_clock = true;
    }
    take(toSample(row, columns), lines.number());
  }
}

/// Says that seconds were taken where nothing names a unit and the rows may as well be
/// milliseconds.
void noteAssumedSeconds(const Layout& layout, const Series& series,
                        std::vector<std::string>& notes) {
  std::vector<double> intervals;
  for (std::size_t k = 1; k < series.size(); ++k)
    intervals.push_back(series.time[k] - series.time[k - 1]);
  const double interval = quantile(std::move(intervals), 0.5);
  if (!layout.time.has_unit && interval >= kTellingInterval)
    notes.push_back("time is taken to count seconds, because the name of column \"" +
                    shortened(layout.names[layout.time.index]) +
                    format("\" has no unit: rows are %g s apart. If it counts another unit, give "
                           "--time-unit",
                           interval));
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
  Layout layout = readLayout(path, lines, columns, false, *notes);
  Recording recording;
  recording.name = printable(path.filename().string());
  Intake intake;
  readRows(lines, layout, columns, *notes,
           [&](const RawSample& sample, std::size_t) { append(recording, intake, sample); });
  if (recording.offered == 0)
    throw RecordingError(path.string() + ": has a header line but no sample below it");
  requireUsable(path.string(), recording);
  noteAssumedSeconds(layout, recording.series, *notes);
  return recording;
}

void readProfileCsv(const std::filesystem::path& path, const CsvColumns& columns,
                    const ProfileRowSeen& row, std::vector<std::string>* notes) {
  TextLines lines(path);
  std::vector<std::string> assumed;
  if (!notes) notes = &assumed;
  Layout layout = readLayout(path, lines, columns, true, *notes);
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
