#include "battery_sof/recording/words.hpp"

#include <cstdarg>
#include <cstdio>

#include "battery_sof/recording/number_text.hpp"

namespace battery_sof {

std::string sentenceOf(const char* pattern, std::va_list arguments) {
  const ClassicNumbers classic;
  std::va_list again;
  va_copy(again, arguments);
  std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, pattern, again)), '\0');
  va_end(again);
  std::vsnprintf(text.data(), text.size() + 1, pattern, arguments);
  return text;
}

std::string sentence(const char* pattern, ...) {
  std::va_list arguments;
  va_start(arguments, pattern);
  std::string text = sentenceOf(pattern, arguments);
  va_end(arguments);
  return text;
}

}  // namespace battery_sof
