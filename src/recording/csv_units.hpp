#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace battery_sof {

/// What the cells of a column count: value [SI] = scale * number + offset.
struct Unit {
  const char* symbol;
  double scale;
  double offset = 0.0;  ///< of degC alone
};

/// What a column may hold, and how its name and its units are written in other programs' files.
struct Quantity {
  const char* meaning;  ///< "time", "current", "voltage" or "temperature"
  const char* option;   ///< that names its column
  std::string own_name;
  /// Common names of its column as bareName() has them, each also with a unit behind.
  std::vector<std::string> names;
  /// Known units: the first is the package's own; each with its spellings as bareName() has them.
  std::vector<std::pair<Unit, std::vector<std::string>>> units;
};

extern const Quantity kTimeQuantity, kCurrentQuantity, kVoltageQuantity, kTemperatureQuantity;

/// @return letters and digits alone, in lower case: "Current [A]" is "currenta", and the micro sign
/// of a unit is "u".
std::string bareName(std::string_view name);

/// @return the unit that a text names ("mA", "[ms]", "seconds"); none where it is not known.
std::optional<Unit> unitOf(const Quantity& quantity, std::string_view text);

/// @return the unit in a column's name: in brackets at its end, behind its last separator
/// ("current_ma"), or behind a common name ("timems"); none where it names none that is known.
std::optional<Unit> unitInName(const Quantity& quantity, std::string_view name);

/// @return whether other programs write a column of this quantity so.
bool isCommonName(const Quantity& quantity, std::string_view name);

/// @return what stands in brackets at the end of a name; empty where nothing does.
std::string_view bracketed(std::string_view name);

/// @return "s, ms, us, ns, min, h".
std::string symbolsOf(const Quantity& quantity);

}  // namespace battery_sof
