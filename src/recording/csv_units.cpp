#include "recording/csv_units.hpp"

#include <cctype>

#include "util/constants.hpp"
#include "util/text.hpp"

namespace battery_sof {

const Quantity kTimeQuantity{
    "time",
    "--time-column",
    "time_s",
    {"time", "t", "timestamp", "timestamps", "elapsedtime", "testtime", "datetime", "seconds",
     "sec", "millis", "milliseconds"},
    {{{"s", 1.0}, {"s", "sec", "secs", "second", "seconds", "utc"}},
     {{"ms", 1e-3}, {"ms", "msec", "msecs", "millis", "millisecond", "milliseconds"}},
     {{"us", 1e-6}, {"us", "usec", "usecs", "micros", "microsecond", "microseconds"}},
     {{"ns", 1e-9}, {"ns", "nsec", "nsecs", "nanos", "nanosecond", "nanoseconds"}},
     {{"min", 60.0}, {"min", "mins", "minute", "minutes"}},
     {{"h", kSecondsPerHour}, {"h", "hr", "hrs", "hour", "hours"}}}};

const Quantity kCurrentQuantity{
    "current",
    "--current-column",
    "current_a",
    {"current", "i", "amp", "amps", "ampere", "amperes", "ibat", "ibatt", "batterycurrent"},
    {{{"A", 1.0}, {"a", "amp", "amps", "ampere", "amperes"}},
     {{"mA", 1e-3}, {"ma", "milliamp", "milliamps", "milliampere", "milliamperes"}},
     {{"kA", 1e3}, {"ka", "kiloamp", "kiloamps", "kiloampere", "kiloamperes"}}}};

const Quantity kVoltageQuantity{
    "voltage",
    "--voltage-column",
    "voltage_v",
    {"voltage", "u", "v", "volt", "volts", "vbat", "vbatt", "ubat", "ubatt", "batteryvoltage"},
    {{{"V", 1.0}, {"v", "volt", "volts"}}, {{"mV", 1e-3}, {"mv", "millivolt", "millivolts"}}}};

const Quantity kTemperatureQuantity{
    "temperature",
    "--temperature-column",
    "temperature_c",
    {"temperature", "temp", "batterytemp", "batterytemperature"},
    {{{"degC", 1.0, kZeroCelsius}, {"c", "degc", "celsius", "degreescelsius"}},
     {{"K", 1.0}, {"k", "kelvin"}}}};

std::string bareName(std::string_view name) {
  // The micro sign (U+00B5 and U+03BC) in UTF-8, and in Latin-1.
  const auto isMicro = [](std::string_view sign) {
    return sign == "\xC2\xB5" || sign == "\xCE\xBC" || sign == "\xB5";
  };
  std::string bare;
  for (std::size_t first = 0, last = 0; first < name.size(); first = last) {
    const auto letter = static_cast<unsigned char>(name[first]);
    const auto isContinued = [&] {
      return (static_cast<unsigned char>(name[last]) & 0xC0) == 0x80;
    };
    for (last = first + 1; letter >= 0xC0 && last < name.size() && isContinued();) ++last;
    if (isMicro(name.substr(first, last - first))) bare += 'u';
    if (letter < 0x80 && std::isalnum(letter)) bare += static_cast<char>(std::tolower(letter));
  }
  return bare;
}

std::optional<Unit> unitOf(const Quantity& quantity, std::string_view text) {
  const std::string bare = bareName(text);
  for (const auto& [unit, spellings] : quantity.units)
    if (contains(spellings, bare)) return unit;
  return std::nullopt;
}

std::string_view bracketed(std::string_view name) {
  if (name.empty() || (name.back() != ')' && name.back() != ']')) return {};
  const std::size_t open = name.rfind(name.back() == ')' ? '(' : '[');
  if (open == std::string_view::npos) return {};
  return name.substr(open + 1, name.size() - open - 2);
}

std::optional<Unit> unitInName(const Quantity& quantity, std::string_view name) {
  if (const std::string_view inside = bracketed(name); !inside.empty())
    return unitOf(quantity, inside);
  if (const std::size_t last = name.find_last_of("_ ./,-"); last != std::string_view::npos)
    if (const auto unit = unitOf(quantity, name.substr(last + 1))) return unit;
  const std::string bare = bareName(name);
  // "timestamps" is the plural of a name, and "seconds" is both name and unit.
  if (contains(quantity.names, bare)) return unitOf(quantity, bare);
  for (const std::string& common : quantity.names)
    if (bare.rfind(common, 0) == 0)
      if (const auto unit = unitOf(quantity, std::string_view(bare).substr(common.size())))
        return unit;
  return std::nullopt;
}

bool isCommonName(const Quantity& quantity, std::string_view name) {
  const std::string bare = bareName(name);
  if (contains(quantity.names, bare)) return true;
  for (const std::string& common : quantity.names)
    if (bare.rfind(common, 0) == 0 &&
        unitOf(quantity, std::string_view(bare).substr(common.size())))
      return true;
  return false;
}

std::string symbolsOf(const Quantity& quantity) {
  std::vector<std::string> symbols;
  for (const auto& [unit, spellings] : quantity.units) symbols.emplace_back(unit.symbol);
  return join(symbols);
}

}  // namespace battery_sof
