#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
const fs::path kRoot = BATTERY_SOF_SOURCE_DIR;

/// Text that was to be filled in: a word between two pairs of @.
const std::regex kPlaceholder(R"(@@\w+@@)");

/// What a reader of the project reads: the pages at its root and below docs/.
std::vector<fs::path> documents() {
  std::vector<fs::path> files;
  const auto add = [&files](const fs::path& file) {
    const auto extension = file.extension();
    if (extension == ".md" || extension == ".rst") files.push_back(file);
  };
  for (const auto& entry : fs::directory_iterator(kRoot)) add(entry.path());
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "docs")) add(entry.path());
  return files;
}

TEST(Documents, AreFound) {
  EXPECT_GT(documents().size(), 10u);
  EXPECT_TRUE(fs::exists(kRoot / "README.md"));
}

TEST(Documents, HoldNoPlaceholder) {
  for (const auto& file : documents()) {
    std::ifstream in(file);
    int number = 0;
    for (std::string line; std::getline(in, line);) {
      ++number;
      std::smatch match;
      EXPECT_FALSE(std::regex_search(line, match, kPlaceholder))
          << file << ":" << number << ": " << match.str();
    }
  }
}

TEST(Documents, APlaceholderWouldBeSeen) {
  const std::string mark = "@@";
  EXPECT_TRUE(std::regex_search("text " + mark + "EXAMPLES" + mark, kPlaceholder));
  EXPECT_FALSE(std::regex_search("@@ -1,2 +1,3 @@ of a patch", kPlaceholder));
}

}  // namespace
