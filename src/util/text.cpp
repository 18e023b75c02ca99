#include "util/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <stdexcept>

#include "util/number_text.hpp"

namespace battery_sof {

std::string countsText(std::initializer_list<std::pair<std::size_t, const char*>> counts) {
  std::vector<std::string> parts;
  for (const auto& [count, what] : counts)
    if (count > 0) parts.push_back(std::to_string(count) + " " + what);
  return join(parts);
}

std::string sentenceOf(const char* pattern, std::va_list arguments) {
  const ClassicNumbers classic;
  std::va_list again;
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
  return text;
}

std::string format(const char* pattern, ...) {
  std::va_list arguments;
  va_start(arguments, pattern);
  std::string text = sentenceOf(pattern, arguments);
  va_end(arguments);
  return text;
}

void requireThat(bool as_expected, const std::string& name, double value, const char* expected) {
  if (as_expected && std::isfinite(value)) return;
  throw std::invalid_argument(format("%s is %g, expected %s", name.c_str(), value, expected));
}

}  // namespace battery_sof
