#include "util/text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

namespace battery_sof {
namespace {

TEST(NumberOf, ReadsWhatIsWrittenInFilesExactly) {
  for (const char* text : {"0", "-0", "12.5", "+12.5", "-400", ".5", "5.", "1e3", "1E-3",
                           "-2.5e+02", "0.1", "3.5999999999999996"})
    EXPECT_EQ(numberOf(text), std::strtod(text, nullptr)) << text;
  EXPECT_TRUE(std::signbit(*numberOf("-0")));
}

TEST(NumberOf, KnowsInfinityAndNotANumber) {
  EXPECT_EQ(numberOf("inf"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(numberOf("-Infinity"), -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(numberOf("nan").value_or(0.0)));
  EXPECT_TRUE(std::isnan(numberOf("NaN").value_or(0.0)));
}

TEST(NumberOf, RoundsWhatNoDoubleHolds) {
  EXPECT_EQ(numberOf("1e999"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(numberOf("-1e999"), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(numberOf("1e-999"), 0.0);
  EXPECT_EQ(numberOf("4e-320"), 4e-320);
}

TEST(NumberOf, RefusesWhatIsNotOneNumber) {
  for (const char* text : {"", " 1", "1 ", "1,5", "1.2.3", "0x10", "lots", "--1", "+-1", "-+1",
                           "++1", "+", "1e", "12V", "\n1"})
    EXPECT_EQ(numberOf(text), std::nullopt) << '"' << text << '"';
}

TEST(NumberOf, ReadsNoFurtherThanItsView) {
  EXPECT_EQ(numberOf(std::string_view("12.345").substr(0, 4)), 12.3);
}

}  // namespace
}  // namespace battery_sof
