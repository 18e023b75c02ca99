#pragma once

#include <string>

namespace battery_sof {

/// What becomes of line breaks.
enum class LineBreaks { kEscaped, kKept };

/**
 * @brief Text that may hold pieces of a file or a command line, safe to show on a terminal and in a message.
 *
 * Control characters (below 0x20, 0x7f, and U+0080 to U+009F) become \xNN, a tab and an escaped line break \t and \n; bytes that
 * are not UTF-8 become \xNN too. Everything else stays.
 */
std::string printable(const std::string& text, LineBreaks line_breaks = LineBreaks::kEscaped);

}  // namespace battery_sof
