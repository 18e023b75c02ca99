#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;
const fs::path kRoot = BATTERY_SOF_SOURCE_DIR;
constexpr int kMaxLines = 550;         // of a file
constexpr int kMaxFunctionLines = 80;  // from its first line to its closing brace

struct Function {
  std::string head;
  int line = 0, lines = 0;
};

std::string textOf(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Where something that begins at `at` and is no code ends; `at` itself where it is code.
std::size_t endOfQuiet(const std::string& text, std::size_t at) {
  const auto behind = [&](const std::string& end, std::size_t from) {
    const std::size_t found = text.find(end, from);
    return found == std::string::npos ? text.size() : found + end.size();
  };
  if (text.compare(at, 2, "//") == 0) return behind("\n", at) - 1;
  if (text.compare(at, 2, "/*") == 0) return behind("*/", at);
  if (text.compare(at, 2, "R\"") == 0)
    return behind(")" + text.substr(at + 2, text.find('(', at) - at - 2) + "\"", at);
  if (text[at] == '#' && (at == 0 || text[at - 1] == '\n')) {
    std::size_t end = text.find('\n', at);
    while (end != std::string::npos && text[end - 1] == '\\') end = text.find('\n', end + 1);
    return end == std::string::npos ? text.size() : end;
  }
  const bool is_separator =
      text[at] == '\'' && at > 0 && std::isalnum(static_cast<unsigned char>(text[at - 1]));
  if ((text[at] != '"' && text[at] != '\'') || is_separator) return at;
  std::size_t end = at + 1;
  while (end < text.size() && text[end] != text[at]) end += text[end] == '\\' ? 2 : 1;
  return end + 1;
}

/// Code alone: comments, texts and directives gone, line ends kept.
std::string codeOf(const std::string& text) {
  std::string code;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(endOfQuiet(text, at), text.size());
    if (end == at) code += text[at++];
    for (; at < end; ++at)
      if (text[at] == '\n') code += '\n';
  }
  return code;
}

bool isFunction(const std::string& head) {
  static const std::regex scope(
      R"(^(inline\s+)?namespace\b|^(template\s*<[^{}]*>\s*)?(class|struct|enum|union)\b)");
  static const std::regex value(R"(=\s*$)");
  return head.find(')') != std::string::npos && !std::regex_search(head, scope) &&
         !std::regex_search(head, value);
}

/// Reads code a character at a time; what stands inside a function, a lambda too, is part of it.
class FunctionReader {
 public:
  std::vector<Function> read(const std::string& code) {
    for (const char c : code) take(c);
    return found_;
  }

 private:
  void take(char c) {
    if (c == '\n') ++line_;
    if (c == '{') return open();
    if (c == '}') return close();
    if (inside_) return;
    if (c == '(') ++parentheses_;
    if (c == ')') --parentheses_;
    if (c == ';' && parentheses_ == 0) return head_.clear();
    if (head_.empty() && std::isspace(static_cast<unsigned char>(c))) return;
    if (head_.empty()) head_line_ = line_;
    head_ += c;
  }
  void open() {
    ++depth_;
    if (inside_ || parentheses_ > 0) return;
    if (isFunction(head_)) {
      inside_ = true;
      function_depth_ = depth_;
      found_.push_back({head_.substr(0, head_.find('\n')), head_line_, 0});
    }
    head_.clear();
  }
  void close() {
    if (inside_ && depth_ == function_depth_) {
      found_.back().lines = line_ - found_.back().line + 1;
      inside_ = false;
    }
    --depth_;
    if (!inside_ && parentheses_ == 0) head_.clear();
  }

  std::vector<Function> found_;
  std::string head_;
  int line_ = 1, head_line_ = 1, depth_ = 0, function_depth_ = 0, parentheses_ = 0;
  bool inside_ = false;
};

/// A function ends before the first line that is not further in than its def; lines of a long text
/// do not count.
std::vector<Function> pythonFunctions(const std::string& text) {
  static const std::regex def(R"(^( *)(async )?def \w+)");
  std::istringstream in(text);
  std::vector<Function> found;
  std::vector<std::pair<std::size_t, std::size_t>> open;  // index, indentation
  bool in_text = false;
  int number = 0, last = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const bool was_in_text = in_text;
    for (std::size_t at = line.find("\"\"\""); at != std::string::npos;
         at = line.find("\"\"\"", at + 3))
      in_text = !in_text;
    const std::size_t indent = line.find_first_not_of(' ');
    if (indent == std::string::npos) continue;
    while (!was_in_text && !open.empty() && indent <= open.back().second && line[indent] != ')') {
      found[open.back().first].lines = last - found[open.back().first].line + 1;
      open.pop_back();
    }
    std::smatch match;
    if (!was_in_text && std::regex_search(line, match, def)) {
      open.push_back({found.size(), indent});
      found.push_back({line, number, 0});
    }
    last = number;
  }
  for (const auto& [index, indent] : open) found[index].lines = last - found[index].line + 1;
  return found;
}

std::vector<Function> functionsOf(const fs::path& file, const std::string& text) {
  if (file.extension() == ".cpp" || file.extension() == ".hpp")
    return FunctionReader().read(codeOf(text));
  if (file.extension() == ".py" ||
      text.substr(0, text.find('\n')).find("python") != std::string::npos)
    return pythonFunctions(text);
  return {};
}

std::vector<fs::path> ownFiles() {
  std::vector<fs::path> files;
  for (const char* folder :
       {"src", "include", "benchmark", "tools", "scripts", "test/architecture"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder))
      if (entry.is_regular_file() && entry.path().extension() != ".pyc")
        files.push_back(entry.path());
  return files;
}

TEST(Lengths, NoFileIsLongerThan550Lines) {
  ASSERT_GT(ownFiles().size(), 300u);
  for (const fs::path& file : ownFiles()) {
    const std::string text = textOf(file);
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), kMaxLines) << fs::relative(file, kRoot);
  }
}

TEST(Lengths, NoFunctionIsLongerThan80Lines) {
  std::size_t seen = 0;
  for (const fs::path& file : ownFiles())
    for (const Function& function : functionsOf(file, textOf(file))) {
      ++seen;
      EXPECT_LE(function.lines, kMaxFunctionLines)
          << fs::relative(file, kRoot).string() << ":" << function.line << " " << function.head;
    }
  EXPECT_GT(seen, 2500u);
}

TEST(Lengths, AreThoseOfWholeFunctions) {
  const auto cpp = functionsOf("a.cpp",
                               "#define A(x) \\\n  {\nnamespace a {\nstruct B {\n  int c = "
                               "f();\n};\n// void no() {\n\nint d(\n    int e = 1'000) {\n"
                               "  const auto g = [](char c) {\n    return c == '{' ? \"}\" : "
                               "R\"(})\";\n  };\n  return 1;\n}\n}\n");
  ASSERT_EQ(cpp.size(), 1u);
  EXPECT_EQ(cpp[0].head, "int d(");
  EXPECT_EQ(cpp[0].line, 9);
  EXPECT_EQ(cpp[0].lines, 7);
  const auto python = functionsOf("a.py",
                                  "def a(\n    b\n):\n    c = \"\"\"\ndef d():\n\"\"\"\n    return "
                                  "c\n\n\nclass E:\n    def f(self):\n     "
                                  "   def g():\n            pass\n        g()\n");
  ASSERT_EQ(python.size(), 3u);
  EXPECT_EQ(python[0].lines, 7);
  EXPECT_EQ(python[1].lines, 4);
  EXPECT_EQ(python[2].lines, 2);
}

}  // namespace
