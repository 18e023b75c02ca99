#include "recording/csv_cells.hpp"

#include <cstdio>
#include <ctime>

#include "util/constants.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

/// Takes a zone from the end of a date: Z, +01:00, -0500 or +01. @return its seconds ahead of UTC, 0
/// for none; nothing where it is no zone.
std::optional<double> takeZone(std::string& text) {
  constexpr std::size_t kShortestDate = 16;  // "2017-03-25 07:00"
  if (!text.empty() && text.back() == 'Z') {
    text.pop_back();
    return 0.0;
  }
  const std::size_t sign = text.find_first_of("+-", kShortestDate);
  if (sign == std::string::npos) return 0.0;
  std::string zone = text.substr(sign + 1);
  if (zone.size() == 5 && zone[2] == ':') zone.erase(2, 1);
  const bool is_zone = (zone.size() == 2 || zone.size() == 4) &&
                       zone.find_first_not_of("0123456789") == std::string::npos;
  if (!is_zone) return std::nullopt;
  const int hours = std::stoi(zone.substr(0, 2));
  const int minutes = zone.size() == 4 ? std::stoi(zone.substr(2)) : 0;
  if (hours > 14 || minutes > 59) return std::nullopt;  // of the world's zones, +14:00 is farthest
  const double ahead = 3600.0 * hours + 60.0 * minutes;
  const double signed_ahead = text[sign] == '-' ? -ahead : ahead;
  text.erase(sign);
  if (text.back() == ' ') text.pop_back();
  return signed_ahead;
}

}  // namespace

std::string withPoint(std::string_view cell, char separator) {
  std::string text(cell);
  const std::size_t comma = text.find(',');
  const bool is_decimal = (separator == ';' || separator == '\t') && comma != std::string::npos &&
                          text.find_first_of(",.", comma + 1) == std::string::npos &&
                          text.find('.') == std::string::npos;
  if (is_decimal) text[comma] = '.';
  return text;
}

std::optional<double> parseNumber(std::string_view cell) {
  return cell.empty() ? kNan : numberOf(cell);
}

std::optional<double> parseDateTime(std::string_view cell) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, used = 0;
  char separator = 0;
  std::string text(cell);
  const std::optional<double> ahead = takeZone(text);
  const int read = std::sscanf(text.c_str(), "%4d-%2d-%2d%c%2d:%2d:%n", &year, &month, &day,
                               &separator, &hour, &minute, &used);
  if (!ahead || read != 6 || used == 0 || (separator != ' ' && separator != 'T'))
    return std::nullopt;
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
  return 86400.0 * days + 3600.0 * hour + 60.0 * minute + *second - *ahead;
}

}  // namespace battery_sof
