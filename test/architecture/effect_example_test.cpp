#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

namespace {

namespace fs = std::filesystem;
const fs::path kRoot = BATTERY_SOF_SOURCE_DIR;

std::string contentOf(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The code block of docs/effects.md that a reader is reported to save.
std::string example() {
  const std::string page = contentOf(kRoot / "docs" / "effects.md");
  const auto begin = page.find("```cpp\n");
  const auto end = page.find("```", begin + 7);
  return begin == std::string::npos ? "" : page.substr(begin + 7, end - begin - 7);
}

struct Compiled {
  int code;
  std::string output;
};

/// The code as the file of an effect, with the package's warnings as errors.
Compiled compiled(const std::string& code) {
  const fs::path file =
      fs::temp_directory_path() / ("battery_sof example " + std::to_string(getpid()) + ".cpp");
  std::ofstream(file) << code;
  const std::string command =
      std::string(BATTERY_SOF_CXX) +
      " -std=c++17 -fsyntax-only -Wall -Wextra -Wpedantic -Wshadow -Werror -I\"" +
      (kRoot / "include").string() + "\" -I\"" + (kRoot / "src").string() + "\" -I\"" +
      (kRoot / "src" / "model" / "effects").string() + "\" -isystem \"" + BATTERY_SOF_EIGEN_DIR +
      "\" \"" + file.string() + "\" 2>&1";
  Compiled result{-1, ""};
  std::array<char, 4096> buffer{};
  FILE* pipe = popen(command.c_str(), "r");
  while (pipe != nullptr && std::fgets(buffer.data(), buffer.size(), pipe) != nullptr)
    result.output += buffer.data();
  if (pipe != nullptr) result.code = pclose(pipe);
  fs::remove(file);
  return result;
}

TEST(EffectsPage, ExampleOfAnEffectCompilesAsItStands) {
  const std::string code = example();
  ASSERT_NE(code.find("effectOf<"), std::string::npos);
  const Compiled result = compiled(code);
  EXPECT_EQ(result.code, 0) << result.output;
}

TEST(EffectsPage, CompilingTheExampleWouldFindAHookThatIsNotOneInEveryArithmetic) {
  // The guard above must be able to fail, inside a template too.
  EXPECT_NE(compiled(std::regex_replace(example(), std::regex("magnitudeOf"), "sizeOf")).code, 0);
}

TEST(EffectsPage, TellsTheLineThatBelongsToTheExample) {
  std::smatch function, line;
  const std::string code = example(), page = contentOf(kRoot / "docs" / "effects.md");
  ASSERT_TRUE(std::regex_search(code, function, std::regex("\nEffect (\\w+)\\(\\)")));
  ASSERT_TRUE(std::regex_search(page, line, std::regex("\n    EFFECT\\((\\w+)\\)\n")));
  EXPECT_EQ(line[1], function[1]);
}

TEST(EffectsPage, ItsExampleWithTheLineThatCutsIntervalsIsCut) {
  std::smatch line, type;
  const std::string code = example(), page = contentOf(kRoot / "docs" / "effects.md");
  ASSERT_TRUE(std::regex_search(page, line, std::regex("`(static constexpr [^`]+;)` cuts")));
  ASSERT_TRUE(std::regex_search(code, type, std::regex("struct (\\w+) \\{\n")));
  const std::string cut =
      std::regex_replace(code, std::regex("struct \\w+ \\{\n"), "$&" + line[1].str() + "\n",
                         std::regex_constants::format_first_only);
  const std::string of_type = "battery_sof::longestPieceOf<battery_sof::" + type[1].str() + ">()";
  const Compiled with = compiled(cut + "static_assert(" + of_type + " > 0.0, \"is not cut\");\n");
  EXPECT_EQ(with.code, 0) << with.output;
  EXPECT_NE(compiled(code + "static_assert(" + of_type + " > 0.0, \"is not cut\");\n").code, 0);
}

TEST(EffectsPage, NamesTheConstantsAnEffectMayHaveAndNoOthers) {
  const std::string page = contentOf(kRoot / "docs" / "effects.md");
  const std::string header =
      contentOf(kRoot / "src" / "model" / "effects" / "effect_definition.hpp");
  const auto names = [](const std::string& text, const char* pattern) {
    std::set<std::string> found;
    const std::regex name(pattern);
    for (std::sregex_iterator at(text.begin(), text.end(), name), end; at != end; ++at)
      found.insert((*at)[1]);
    return found;
  };
  const std::set<std::string> in_code = names(header, R"(BATTERY_SOF_HAS\(\w+, D::(k\w+)\))");
  EXPECT_EQ(names(page, R"(`[^`\n]*\b(k[A-Z]\w+)[^`\n]*`)"), in_code);
  EXPECT_GT(in_code.size(), 4u);
}

TEST(EffectsPage, NamesEveryHookAnEffectMayHave) {
  const std::string page = contentOf(kRoot / "docs" / "effects.md");
  const std::string header =
      contentOf(kRoot / "src" / "model" / "effects" / "effect_definition.hpp");
  const std::regex hook(R"(BATTERY_SOF_HAS\(Has\w+, &D::template (\w+)<)");
  int hooks = 0;
  for (std::sregex_iterator at(header.begin(), header.end(), hook), end; at != end; ++at, ++hooks)
    EXPECT_NE(page.find("| `" + (*at)[1].str() + "` |"), std::string::npos) << (*at)[1];
  EXPECT_GT(hooks, 5);
}

TEST(EffectsPage, NamesOnlyTestsThatExist) {
  const std::string page = contentOf(kRoot / "docs" / "effects.md");
  const std::regex name(R"(`(\w+_test\.cpp)`)");
  for (std::sregex_iterator at(page.begin(), page.end(), name), end; at != end; ++at) {
    bool found = false;
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / "test"))
      found = found || entry.path().filename() == (*at)[1].str();
    EXPECT_TRUE(found) << (*at)[1];
  }
}

}  // namespace
