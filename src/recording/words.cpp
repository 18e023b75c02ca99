#include "battery_sof/recording/words.hpp"

#include <cstdarg>
#include <cstdio>

#include "battery_sof/recording/number_text.hpp"

namespace battery_sof {

std::string sentence(const char* pattern, ...) {
  char text[320];
  std::va_list arguments;
  va_start(arguments, pattern);
  const ClassicNumbers classic;
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

}  // namespace battery_sof
