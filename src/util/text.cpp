#include "util/text.hpp"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>

#include "util/number_text.hpp"

namespace battery_sof {

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

}  // namespace battery_sof
