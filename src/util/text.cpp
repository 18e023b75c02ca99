#include "util/text.hpp"

#include <algorithm>
#include <array>
#include <boost/locale/utf.hpp>
#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace battery_sof {

std::string countsText(std::initializer_list<std::pair<std::size_t, const char*>> counts) {
  std::vector<std::string> parts;
  for (const auto& [count, what] : counts)
    if (count > 0) parts.push_back(std::to_string(count) + " " + what);
  return join(parts);
}

std::string format(const char* pattern, ...) {
  const ClassicNumbers classic;
  std::va_list arguments, again;
  va_start(arguments, pattern);
  va_copy(again, arguments);
  std::array<char, 128> room;
  const auto length =
      static_cast<std::size_t>(std::vsnprintf(room.data(), room.size(), pattern, arguments));
  std::string text(room.data(), std::min(length, room.size() - 1));
  if (text.size() < length) {
    text.resize(length);
    std::vsnprintf(text.data(), text.size() + 1, pattern, again);
  }
  va_end(again);
  va_end(arguments);
  return text;
}

void requireThat(bool as_expected, const std::string& name, double value, const char* expected) {
  if (as_expected && std::isfinite(value)) return;
  throw std::invalid_argument(format("%s is %g, expected %s", name.c_str(), value, expected));
}

std::optional<double> numberOf(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\n\v\f\r";
  if (text.empty() || kBlanks.find(text.front()) != std::string_view::npos) return std::nullopt;
  if (text.find_first_of("xX") != std::string_view::npos) return std::nullopt;
#ifdef __cpp_lib_to_chars
  const std::string_view unsigned_text =
      text.substr(text.front() == '+' && text.substr(1, 1) != "-" ? 1 : 0);
  double value = 0.0;
  const auto [end, error] =
      std::from_chars(unsigned_text.data(), unsigned_text.data() + unsigned_text.size(), value);
  if (error == std::errc() && end == text.data() + text.size()) return value;
  if (error != std::errc::result_out_of_range) return std::nullopt;
#endif
  // Says, too, to what a number is rounded that no double holds.
  const ClassicNumbers classic;
  const std::string whole(text);
  char* last = nullptr;
  const double rounded = std::strtod(whole.c_str(), &last);
  return last == whole.c_str() + whole.size() ? std::optional(rounded) : std::nullopt;
}

ClassicNumbers::ClassicNumbers() {
  static const locale_t classic = newlocale(LC_ALL_MASK, "C", static_cast<locale_t>(nullptr));
  before_ = uselocale(classic);
}

ClassicNumbers::~ClassicNumbers() { uselocale(before_); }

std::string printable(const std::string& text, LineBreaks line_breaks) {
  using Utf8 = boost::locale::utf::utf_traits<char>;
  std::string shown;
  shown.reserve(text.size());
  for (auto at = text.begin(); at != text.end();) {
    const auto first = at;
    const boost::locale::utf::code_point code = Utf8::decode(at, text.end());
    const bool is_character = boost::locale::utf::is_valid_codepoint(code);
    if (!is_character) at = first + 1;
    const bool is_control = code < 0x20u || (code >= 0x7Fu && code < 0xA0u),
               is_kept_break = code == '\n' && line_breaks == LineBreaks::kKept;
    if (is_character && (!is_control || is_kept_break))
      shown.append(first, at);
    else
      std::for_each(first, at, [&shown](char byte) {
        shown += byte == '\n'   ? "\\n"
                 : byte == '\t' ? "\\t"
                                : format("\\x%02x", static_cast<unsigned char>(byte));
      });
  }
  return shown;
}

std::string shortened(std::string_view text, std::size_t most) {
  if (text.size() <= most) return std::string(text);
  return std::string(text.substr(0, most)) + "... (" + std::to_string(text.size()) + " bytes)";
}

}  // namespace battery_sof
