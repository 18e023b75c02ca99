#include "util/text.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace battery_sof
