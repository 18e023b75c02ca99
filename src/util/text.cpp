#include "util/text.hpp"

#include <algorithm>
#include <array>
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

namespace {

locale_t classicLocale() {
  static const locale_t classic = newlocale(LC_ALL_MASK, "C", static_cast<locale_t>(nullptr));
  return classic;
}

/// Says, too, to what a number is rounded that no double holds.
std::optional<double> numberOfC(const std::string& text) {
  const ClassicNumbers classic;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end != text.c_str() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

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
  return numberOfC(std::string(text));
}

ClassicNumbers::ClassicNumbers() : before_(uselocale(classicLocale())) {}

ClassicNumbers::~ClassicNumbers() { uselocale(before_); }

namespace {

/// Bytes of the UTF-8 character that begins there; 0 where none does. Overlong forms and surrogates
/// are none.
std::size_t lengthOfCharacter(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t k) {
    return at + k < text.size() ? static_cast<unsigned char>(text[at + k]) : 0u;
  };
  const auto follows = [&](std::size_t k) { return (byte(k) & 0xC0u) == 0x80u; };
  const unsigned first = byte(0);
  if (first < 0x80u) return 1;
  if (first >= 0xC2u && first <= 0xDFu && follows(1)) return 2;
  const bool is_overlong = first == 0xE0u && byte(1) < 0xA0u,
             is_surrogate = first == 0xEDu && byte(1) >= 0xA0u;
  if ((first & 0xF0u) == 0xE0u && follows(1) && follows(2) && !is_overlong && !is_surrogate)
    return 3;
  const bool in_range = (first == 0xF0u && byte(1) >= 0x90u) || (first > 0xF0u && first < 0xF4u) ||
                        (first == 0xF4u && byte(1) < 0x90u);
  return in_range && follows(1) && follows(2) && follows(3) ? 4 : 0;
}

bool isControl(const std::string& text, std::size_t at, std::size_t length) {
  const auto first = static_cast<unsigned char>(text[at]);
  if (length == 1) return first < 0x20u || first == 0x7Fu;
  return length == 2 && first == 0xC2u && static_cast<unsigned char>(text[at + 1]) < 0xA0u;
}

void appendEscaped(std::string& shown, char byte) {
  char code[8];
  std::snprintf(code, sizeof code, "\\x%02x",
                static_cast<unsigned>(static_cast<unsigned char>(byte)));
  shown += byte == '\n' ? "\\n" : byte == '\t' ? "\\t" : code;
}

}  // namespace

std::string printable(const std::string& text, LineBreaks line_breaks) {
  std::string shown;
  shown.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = lengthOfCharacter(text, at);
    const std::size_t bytes = length == 0 ? 1 : length;
    const bool is_kept_break = text[at] == '\n' && line_breaks == LineBreaks::kKept;
    if (!is_kept_break && (length == 0 || isControl(text, at, length)))
      for (std::size_t k = 0; k < bytes; ++k) appendEscaped(shown, text[at + k]);
    else
      shown.append(text, at, bytes);
    at += bytes;
  }
  return shown;
}

std::string shortened(std::string_view text, std::size_t most) {
  if (text.size() <= most) return std::string(text);
  return std::string(text.substr(0, most)) + "... (" + std::to_string(text.size()) + " bytes)";
}

}  // namespace battery_sof
