#pragma once

#include <locale.h>

#include <optional>
#include <string_view>

namespace battery_sof {

// Numbers as text with a point for the decimals, whatever locale the program around the core has
// set: with setlocale(), with std::locale::global(), or as Python's locale.setlocale().

/**
 * @return the whole text as a number: decimal, an exponent, a sign, inf and nan as strtod() knows
 * them, infinite or 0 where a
 *   double cannot hold it; none for anything else (empty, blanks around it, hexadecimal, a comma).
 */
std::optional<double> numberOf(std::string_view text);

/// While it lives, this thread's C functions (printf, strtod) read and write numbers as in the
/// classic locale.
class ClassicNumbers {
 public:
  ClassicNumbers();
  ~ClassicNumbers();
  ClassicNumbers(const ClassicNumbers&) = delete;
  ClassicNumbers& operator=(const ClassicNumbers&) = delete;

 private:
  locale_t before_;
};

}  // namespace battery_sof
