#include "util/text.hpp"

#include <gtest/gtest.h>

namespace battery_sof {
namespace {

TEST(Printable, ControlCharactersAreShownAsTheirCodes) {
  EXPECT_EQ(printable("a\x1b[31mred\x07"), "a\\x1b[31mred\\x07");
  EXPECT_EQ(printable("one\ntwo\tthree\r"), "one\\ntwo\\tthree\\x0d");
  EXPECT_EQ(printable(std::string("\0\x7f", 2)), "\\x00\\x7f");
  EXPECT_EQ(printable("\xC2\x9B"
                      "31m"),
            "\\xc2\\x9b31m")
      << "U+009B begins a terminal's command as ESC [ does";
}

TEST(Shortened, SaysHowLongItWas) {
  EXPECT_EQ(shortened("short", 5), "short");
  EXPECT_EQ(shortened("longer", 5), "longe... (6 bytes)");
}

TEST(Printable, LineBreaksAreKeptWhereTheyAreTheWritersOwn) {
  EXPECT_EQ(printable("one\ntwo\x1b", LineBreaks::kKept), "one\ntwo\\x1b");
}

TEST(Printable, TextInUtf8StaysAsItIs) {
  const std::string text =
      "Batterie: 12 V, 25 \xC2\xB0"
      "C, \xE2\x82\xAC, \xF0\x9F\x94\x8B";
  EXPECT_EQ(printable(text), text);
}

TEST(Printable, BytesThatAreNoUtf8AreShownAsTheirCodes) {
  EXPECT_EQ(printable("\xFF\xC3"), "\\xff\\xc3");
  EXPECT_EQ(printable("\xC0\xAF"), "\\xc0\\xaf") << "an overlong form";
  EXPECT_EQ(printable("\xED\xA0\x80"), "\\xed\\xa0\\x80") << "a surrogate";
  EXPECT_EQ(printable("\xE2\x82"), "\\xe2\\x82") << "cut off";
}

}  // namespace
}  // namespace battery_sof
