#pragma once

#include <locale.h>

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace battery_sof {

/// Whether a list has an entry: an id among ids.
template <typename Entry, typename Wanted>
bool contains(const std::vector<Entry>& list, const Wanted& wanted) {
  return std::find(list.begin(), list.end(), wanted) != list.end();
}

/// @return ids, names or sentences one after the other, empty ones left out.
template <typename Names>
std::string join(const Names& names, const char* between = ", ") {
  std::string text;
  for (const auto& name : names) {
    if (name.empty()) continue;
    if (!text.empty()) text += between;
    text += name;
  }
  return text;
}

/// @return "3 stuck, 1 repeated": what there is any of. @param counts each with what it counts.
std::string countsText(std::initializer_list<std::pair<std::size_t, const char*>> counts);

/// Formatted text, in the classic locale.
__attribute__((format(printf, 1, 2))) std::string format(const char* pattern, ...);

/// @throws std::invalid_argument "name is value, expected what" unless a value is as expected and
/// finite.
void requireThat(bool as_expected, const std::string& name, double value, const char* expected);

// Numbers as text with a point for the decimals, whatever locale the program around the core has
// set: with setlocale(), with std::locale::global(), or as Python's locale.setlocale().

/// @return the whole text as a number: decimal, an exponent, a sign, inf and nan as strtod() knows
/// them, infinite or 0 where a double cannot hold it; none for anything else (empty, blanks around
/// it, hexadecimal, a comma).
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

/// What becomes of line breaks.
enum class LineBreaks { kEscaped, kKept };

/**
 * @brief Text that may hold pieces of a file or a command line, safe to show on a terminal and in a
 * message.
 *
 * Control characters (below 0x20, 0x7f, and U+0080 to U+009F) become \xNN, a tab and an escaped
 * line break \t and \n; bytes that are not UTF-8 become \xNN too. Everything else stays.
 */
std::string printable(const std::string& text, LineBreaks line_breaks = LineBreaks::kEscaped);

/// @return text as it is, or where it is longer its beginning and how long it all is. @param most
/// [bytes] that are kept.
std::string shortened(std::string_view text, std::size_t most = 60);

/// @return the first of some names, each shortened, and how many more there are.
template <typename Names>
std::string someOf(const Names& names) {
  constexpr std::size_t kMost = 20;
  std::string text;
  std::size_t count = 0;
  for (const auto& name : names)
    if (!name.empty() && count++ < kMost) text += (text.empty() ? "" : ", ") + shortened(name);
  return count > kMost ? text + " and " + std::to_string(count - kMost) + " more" : text;
}

}  // namespace battery_sof
