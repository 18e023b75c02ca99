#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace battery_sof {

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
