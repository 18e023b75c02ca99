#include "util/text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace battery_sof {
namespace {

TEST(Sentence, IsAsLongAsItsWords) {
  const std::string path(2000, 'p');
  EXPECT_EQ(format("%s: %d rows", path.c_str(), 7), path + ": 7 rows");
  EXPECT_EQ(format("%s", ""), "");
  for (std::size_t length = 100; length < 150; ++length)
    EXPECT_EQ(format("%s", path.substr(0, length).c_str()).size(), length);
}

TEST(Sentence, IsPrintf) { EXPECT_EQ(format("%.2f|%d", 1.25, 7), "1.25|7"); }

TEST(Listed, LeavesOutWhatIsEmpty) {
  EXPECT_EQ(join(std::vector<std::string>{"a", "", "b"}), "a, b");
  EXPECT_EQ(join(std::vector<std::string>{"", "b"}, " or "), "b");
}

TEST(RequireThat, NamesTheValueAndWhatWasExpected) {
  EXPECT_NO_THROW(requireThat(true, "c2 [F]", 3.0, "above 0"));
  EXPECT_THROW(requireThat(true, "c2 [F]", std::nan(""), "above 0"), std::invalid_argument);
  try {
    requireThat(false, "c2 [F]", -3.5, "above 0");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "c2 [F] is -3.5, expected above 0");
  }
}

}  // namespace
}  // namespace battery_sof
