#include "util/number_text.hpp"

#include <charconv>
#include <cstdlib>
#include <string>

namespace battery_sof {
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

}  // namespace battery_sof
