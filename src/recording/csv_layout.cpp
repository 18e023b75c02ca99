#include "recording/csv_layout.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "recording/csv_cells.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr std::array<std::pair<const Quantity*, Column Layout::*>, 4> kReadColumns{
    {{&kTimeQuantity, &Layout::time},
     {&kCurrentQuantity, &Layout::current},
     {&kVoltageQuantity, &Layout::voltage},
     {&kTemperatureQuantity, &Layout::temperature}}};

// ---------------------------------------------------------------------------------------------
// lines

/// The characters that begin a comment, as many as there are; 0 for content.
std::size_t commentMark(std::string_view line) {
  const std::string_view text = line.substr(std::min(line.find_first_not_of(" \t"), line.size()));
  const bool is_comment = text.front() == '#' || text.front() == '%' || text.substr(0, 2) == "//";
  if (!is_comment || text.substr(0, 7) == "#ROSBAG") return 0;
  return line.find_first_not_of(" \t#%/") == std::string_view::npos
             ? line.size()
             : line.find_first_not_of(" \t#%/");
}

std::vector<std::string> namesIn(std::string_view header, char separator) {
  std::vector<std::string_view> cells;
  splitCells(header, separator, cells);
  return {cells.begin(), cells.end()};
}

void splitHeader(Layout& layout, std::string_view header, const std::string& time_column) {
  layout.separator = ',';
  layout.names = namesIn(header, ',');
  for (const char separator : {';', '\t'}) {
    if (contains(layout.names, time_column)) return;
    std::vector<std::string> names = namesIn(header, separator);
    if (names.size() > layout.names.size() || contains(names, time_column))
      layout.separator = separator, layout.names = std::move(names);
  }
}

/// Whether a line has a number, a date or nothing in each of as many cells as the header has.
bool isRowOfNumbers(const Layout& layout, std::string_view line) {
  std::vector<std::string_view> cells;
  splitCells(line, layout.separator, cells);
  return cells.size() == layout.names.size() &&
         std::all_of(cells.begin(), cells.end(), [&](std::string_view cell) {
           const std::string text = withPoint(cell, layout.separator);
           return parseNumber(text) || parseDateTime(text);
         });
}

// ---------------------------------------------------------------------------------------------
// columns

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

std::vector<std::string> commonlyNamed(const Layout& layout, const Quantity& quantity) {
  std::vector<std::string> found;
  for (const std::string& name : layout.names)
    if (isCommonName(quantity, name)) found.push_back(name);
  return found;
}

/// The column that was asked for; where that is the package's own name and the file does not have
/// it, the one column of a common name. A profile has no option that names one.
std::size_t indexOf(const Layout& layout, const std::string& name, const Quantity& quantity,
                    bool is_profile, std::vector<std::string>& notes) {
  if (name != quantity.own_name || contains(layout.names, name)) return columnIndex(layout, name);
  const std::vector<std::string> found = commonlyNamed(layout, quantity);
  const std::string meaning = quantity.meaning;
  const std::string rename = "rename that of the " + meaning + " to " + name;
  if (found.size() > 1)
    throw RecordingError(layout.path.string() + ": has no column \"" + name + "\", and " +
                         someOf(found) + " may be the " + meaning + ": " +
                         (is_profile ? rename : std::string("name one with ") + quantity.option));
  if (found.empty())
    return columnIndex(
        layout, name,
        "; " + (is_profile ? rename : "name that of the " + meaning + " with " + quantity.option));
  notes.push_back(meaning + " is read from column \"" + found.front() + "\"");
  return columnIndex(layout, found.front());
}

/// Notes a unit that is not the package's own, and who says so.
void noteUnit(const Quantity& quantity, const Unit& unit, const char* by,
              std::vector<std::string>& notes) {
  if (unit.symbol != std::string(quantity.units.front().first.symbol))
    notes.push_back(std::string(quantity.meaning) + " is taken to count " + unit.symbol + ", by " +
                    by);
}

Column columnOf(const Layout& layout, std::size_t index, const Quantity& quantity,
                std::vector<std::string>& notes) {
  const std::string& name = layout.names[index];
  const auto unit = unitInName(quantity, name);
  const Unit& own = quantity.units.front().first;
  if (unit) noteUnit(quantity, *unit, "its column's name", notes);
  if (!unit && !bracketed(name).empty())
    notes.push_back(std::string(quantity.meaning) + " is taken to count " + own.symbol + ": \"" +
                    shortened(bracketed(name)) + "\" in its column's name is none of " +
                    symbolsOf(quantity));
  return {index, unit.value_or(own), unit.has_value()};
}

}  // namespace

bool nextOfContent(TextLines& lines) {
  while (lines.next())
    if (commentMark(lines.line()) == 0) return true;
  return false;
}

Layout readLayout(const std::filesystem::path& path, TextLines& lines, const CsvColumns& columns,
                  bool is_profile, std::vector<std::string>& notes) {
  std::string comment;
  bool has_content = false;
  while (!has_content && lines.next()) {
    const std::size_t mark = commentMark(lines.line());
    if (mark > 0)
      comment = lines.line().substr(mark);
    else
      has_content = true;
  }
  if (!has_content)
    throw RecordingError(path.string() + ": is empty, expected a header line with the columns " +
                         columns.time + ", " + columns.current +
                         (is_profile ? "" : ", " + columns.voltage));
  Layout layout;
  layout.path = path;
  splitHeader(layout, comment, columns.time);
  layout.is_at_first_row = layout.names.size() > 1 && isRowOfNumbers(layout, lines.line());
  if (!layout.is_at_first_row) splitHeader(layout, lines.line(), columns.time);
  const auto read = [&](const std::string& name, const Quantity& quantity) {
    return columnOf(layout, indexOf(layout, name, quantity, is_profile, notes), quantity, notes);
  };
  layout.time_unit_is_given = columns.time_unit.has_value();
  if (columns.time_unit)
    layout.time = {indexOf(layout, columns.time, kTimeQuantity, is_profile, notes),
                   Unit{"given", *columns.time_unit}, true};
  else
    layout.time = read(columns.time, kTimeQuantity);
  layout.current = read(columns.current, kCurrentQuantity);
  if (!is_profile) {
    layout.voltage = read(columns.voltage, kVoltageQuantity);
    const std::string temperature = columns.temperature.value_or(kTemperatureQuantity.own_name);
    if (columns.temperature || contains(layout.names, temperature) ||
        commonlyNamed(layout, kTemperatureQuantity).size() == 1)
      layout.temperature = read(temperature, kTemperatureQuantity);
  }
  return layout;
}

bool takeUnitsRow(Layout& layout, const std::vector<std::string_view>& cells, std::size_t line,
                  std::vector<std::string>& notes) {
  if (cells.size() < layout.names.size()) return false;
  for (const std::size_t index : {layout.time.index, layout.current.index, layout.voltage.index}) {
    if (index == kNoColumn) continue;
    const std::string unit = bareName(cells[index]);
    const bool is_word = !unit.empty() && unit != "nan" && unit != "inf" &&
                         std::none_of(unit.begin(), unit.end(),
                                      [](char letter) { return letter >= '0' && letter <= '9'; });
    if (!is_word) return false;
  }
  for (const auto& [quantity, member] : kReadColumns) {
    Column& column = layout.*member;
    if (column.index == kNoColumn || cells[column.index].empty()) continue;
    if (member == &Layout::time && layout.time_unit_is_given) continue;
    const auto unit = unitOf(*quantity, cells[column.index]);
    const bool is_other =
        unit && column.has_unit && unit->symbol != std::string(column.unit.symbol);
    if (!unit || is_other)
      throw RecordingError(
          layout.path.string() + ", line " + std::to_string(line) + ", column \"" +
          shortened(layout.names[column.index]) + "\": \"" + shortened(cells[column.index]) +
          "\" is not " +
          (unit ? std::string("the unit in the column's name, ") + column.unit.symbol
                : std::string("a unit of ") + quantity->meaning +
                      " that is known, expected one of " + symbolsOf(*quantity)));
    if (!column.has_unit) noteUnit(*quantity, *unit, "the row of units below the header", notes);
    column.unit = *unit;
    column.has_unit = true;
  }
  return true;
}

}  // namespace battery_sof
