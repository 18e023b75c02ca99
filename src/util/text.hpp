#pragma once

#include <algorithm>
#include <cstdarg>
#include <initializer_list>
#include <string>
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

/// format() for functions that take a pattern's arguments themselves.
__attribute__((format(printf, 1, 0))) std::string sentenceOf(const char* pattern,
                                                             std::va_list arguments);

}  // namespace battery_sof
