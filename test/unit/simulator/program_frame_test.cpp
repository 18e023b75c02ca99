#include "simulator/program_frame.hpp"

#include <gtest/gtest.h>

namespace battery_sof_simulator {
namespace {

TEST(Shown, TextOfAnyLanguageStays) {
  EXPECT_EQ(shown("f\xC3\xA4hrt \xE2\x82\xAC \xF0\x9F\x94\x8B"),
            "f\xC3\xA4hrt \xE2\x82\xAC \xF0\x9F\x94\x8B");
}

TEST(Shown, WhatATerminalObeysAndWhatIsNoUtf8IsShownByItsCodes) {
  EXPECT_EQ(shown("a\x1b[31m\n\x7f"), "a\\x1b[31m\\x0a\\x7f");
  EXPECT_EQ(shown("\xC2\x9B \xFF \xC3"), "\\xc2\\x9b \\xff \\xc3");
  EXPECT_EQ(shown("\xC0\xAF\xE0\x80\x80\xED\xA0\x80\xF4\x90\x80\x80"),
            "\\xc0\\xaf\\xe0\\x80\\x80\\xed\\xa0\\x80\\xf4\\x90\\x80\\x80");
  EXPECT_EQ(shown("\xE2\x82"), "\\xe2\\x82") << "cut off";
}

TEST(Shown, ALongTextIsCutOff) { EXPECT_LT(shown(std::string(1000000, 'x')).size(), 11000u); }

}  // namespace
}  // namespace battery_sof_simulator
