#include "simulator/shown_text.hpp"

#include <cstdio>

namespace battery_sof_simulator {
namespace {

constexpr std::size_t kMost = 10000;  // [bytes], two paths

unsigned byteOf(const std::string& text, std::size_t at) {
  return at < text.size() ? static_cast<unsigned char>(text[at]) : 0u;
}

/// Bytes of the UTF-8 character that begins there, 0 where none does or one that a terminal obeys
/// (below U+0020, U+007F to U+009F).
std::size_t charactersLength(const std::string& text, std::size_t at) {
  const unsigned first = byteOf(text, at), second = byteOf(text, at + 1);
  if (first < 0x80u) return first >= 0x20u && first != 0x7Fu ? 1 : 0;
  const std::size_t length = first < 0xC2u   ? 0
                             : first < 0xE0u ? 2
                             : first < 0xF0u ? 3
                             : first < 0xF5u ? 4
                                             : 0;
  // overlong forms, controls
  const unsigned least = first == 0xE0u || first == 0xC2u ? 0xA0u : first == 0xF0u ? 0x90u : 0x80u;
  // surrogates, beyond U+10FFFF
  const unsigned most = first == 0xEDu ? 0x9Fu : first == 0xF4u ? 0x8Fu : 0xBFu;
  if (length == 0 || second < least || second > most) return 0;
  for (std::size_t k = 2; k < length; ++k)
    if ((byteOf(text, at + k) & 0xC0u) != 0x80u) return 0;
  return length;
}

}  // namespace

std::string shown(const std::string& text) {
  std::string line;
  for (std::size_t at = 0; at < text.size();) {
    if (line.size() > kMost) return line + "...";
    const std::size_t length = charactersLength(text, at);
    char code[8];
    std::snprintf(code, sizeof code, "\\x%02x", byteOf(text, at));
    line += length > 0 ? text.substr(at, length) : code;
    at += length > 0 ? length : 1;
  }
  return line;
}

}  // namespace battery_sof_simulator
