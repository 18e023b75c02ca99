#include <gtest/gtest.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
const fs::path kRoot = BATTERY_SOF_SOURCE_DIR;
constexpr std::uintmax_t kLargestText = 2000000;  // bytes; what is larger was not written by hand

/// A page, or a section of it, that a line speaks of.
struct Citation {
  /// as written: from the root, or relative to the page that links it; empty: the same page
  std::string page;
  std::string anchor;  ///< empty: the page as a whole
  int line = 0;
  bool is_link = false;
};

/// Name of a heading in links: small letters, digits, hyphens and underscores; spaces become
/// hyphens.
std::string anchorOf(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalnum(letter) || c == '_' || c == '-')
      anchor += static_cast<char>(std::tolower(letter));
    if (c == ' ') anchor += '-';
  }
  return anchor;
}

/// Names of a page's headings; code between fences has none. A second heading of one name ends in
/// -1.
std::set<std::string> anchorsIn(const std::string& text) {
  std::set<std::string> anchors;
  std::istringstream lines(text);
  bool is_code = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("```", 0) == 0) is_code = !is_code;
    const std::size_t marks = line.find_first_not_of('#');
    if (is_code || marks == 0 || marks > 6 || marks == std::string::npos || line[marks] != ' ')
      continue;
    const std::string anchor = anchorOf(line.substr(marks + 1));
    std::string name = anchor;
    for (int k = 1; !anchors.insert(name).second; ++k) name = anchor + "-" + std::to_string(k);
  }
  return anchors;
}

void append(std::vector<Citation>& citations, const std::string& line, const std::regex& form,
            Citation like) {
  for (std::sregex_iterator match(line.begin(), line.end(), form), end; match != end; ++match) {
    like.page = (*match)[1];
    like.anchor = (*match)[2];
    citations.push_back(like);
  }
}

/// docs/PAGE.md and docs/PAGE.md#SECTION anywhere; in a page its links too, but those to other
/// sites.
std::vector<Citation> citationsIn(const std::string& text, bool is_page) {
  static const std::regex kNamed(R"((docs/[\w/.-]+\.md)(?:#([\w-]+))?)"),
      kLink(R"(\]\(([^)#:\s]*)(?:#([^)\s]+))?\))");
  std::vector<Citation> citations;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.find("docs/") != std::string::npos)
      append(citations, line, kNamed, {"", "", number, false});
    if (is_page && line.find("](") != std::string::npos)
      append(citations, line, kLink, {"", "", number, true});
  }
  return citations;
}

/// Notes that are not in the repository, cited by a number, a letter and a number, or as a whole.
std::regex outsideNotes() {
  const std::string physics = std::string("PHY") + "SICS";
  const std::string names = physics + "|JUD" + "GE|SOU" + "RCE|HOU" + "SE|CON" + "TRACT";
  return std::regex("\\b(" + names + ")('|\\.md\\b|,? (section )?[A-Z]?[0-9])|\\bids? of " +
                    physics);
}

std::string textOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Texts of the repository: its root's files, and those in the folders that people write in.
std::vector<fs::path> writtenFiles() {
  std::vector<fs::path> files;
  const auto add = [&files](const fs::directory_entry& entry) {
    if (entry.is_regular_file() && entry.file_size() < kLargestText &&
        textOf(entry.path()).find('\0') == std::string::npos)
      files.push_back(entry.path());
  };
  for (const auto& entry : fs::directory_iterator(kRoot)) add(entry);
  for (const char* folder : {"action", "benchmark", "cmake", "config", "docs", "include", "launch",
                             "msg", "scripts", "src", "srv", "test"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder))
      if (entry.path().string().find("__pycache__") == std::string::npos) add(entry);
  return files;
}

/// Why a citation leads nowhere; empty when it leads somewhere.
std::string faultOf(const Citation& citation, const fs::path& file) {
  static std::map<fs::path, std::set<std::string>> known;
  const fs::path page = citation.page.empty()
                            ? file
                            : (citation.is_link ? file.parent_path() : kRoot) / citation.page;
  if (!fs::exists(page)) return citation.page + " does not exist";
  if (citation.anchor.empty()) return "";
  const auto found = known.find(page);
  const std::set<std::string>& anchors =
      found != known.end() ? found->second
                           : known.emplace(page, anchorsIn(textOf(page))).first->second;
  return anchors.count(citation.anchor) > 0 ? ""
                                            : citation.page + " has no section #" + citation.anchor;
}

TEST(Citations, LeadToPagesAndSectionsThatAreThere) {
  std::size_t sections = 0;
  for (const fs::path& file : writtenFiles()) {
    if (file.filename() == "citations_test.cpp") continue;  // its examples lead nowhere
    for (const Citation& citation : citationsIn(textOf(file), file.extension() == ".md")) {
      sections += citation.anchor.empty() ? 0 : 1;
      const std::string fault = faultOf(citation, file);
      EXPECT_TRUE(fault.empty()) << file << ":" << citation.line << ": " << fault;
    }
  }
  EXPECT_GT(sections, 100u);
}

TEST(Citations, AreOfNothingOutsideTheRepository) {
  const std::regex outside = outsideNotes();
  for (const fs::path& file : writtenFiles()) {
    std::istringstream lines(textOf(file));
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      std::smatch match;
      EXPECT_FALSE(std::regex_search(line, match, outside))
          << file << ":" << number << ": " << match.str();
    }
  }
}

TEST(Citations, OfOutsideNotesWouldBeSeen) {
  const std::regex outside = outsideNotes();
  const std::string physics = std::string("PHY") + "SICS", judge = std::string("JUD") + "GE";
  for (const std::string& text : {physics + " 1.2", physics + " P9", physics + ", section 1",
                                  "ids of " + physics, judge + " 6", judge + ".md"})
    EXPECT_TRUE(std::regex_search(text, outside)) << text;
  for (const std::string& text :
       {physics + " | INSTRUMENT", std::string("set_property(SOURCE src/x.cpp"),
        std::string("IN CONTRACT, STRICT")})
    EXPECT_FALSE(std::regex_search(text, outside)) << text;
}

TEST(Citations, OfASectionAreReadInCommentsAndLinks) {
  const auto comment =
      citationsIn("// [s], docs/physics.md#gassing: two plateaus (docs/model.md).", false);
  ASSERT_EQ(comment.size(), 2u);
  EXPECT_EQ(comment[0].page, "docs/physics.md");
  EXPECT_EQ(comment[0].anchor, "gassing");
  EXPECT_EQ(comment[1].anchor, "");
  const auto link =
      citationsIn("first\n[x](model.md#the-step), [y](#here), [z](https://example.org/#a)", true);
  ASSERT_EQ(link.size(), 2u);
  EXPECT_EQ(link[0].anchor, "the-step");
  EXPECT_EQ(link[1].page, "");
  EXPECT_EQ(link[1].line, 2);
}

TEST(Citations, OfAMissingPageOrSectionWouldBeSeen) {
  const fs::path page = kRoot / "docs" / "physics.md";
  EXPECT_NE(faultOf({"docs/physics.md", "no-such-section", 1, false}, page), "");
  EXPECT_NE(faultOf({"docs/no_such_page.md", "", 1, false}, page), "");
  EXPECT_EQ(faultOf({"docs/physics.md", "gassing", 1, false}, page), "");
  EXPECT_EQ(faultOf({"", "gassing", 1, true}, page), "");
}

TEST(Citations, FindHeadingsAsPagesShowThem) {
  const auto anchors = anchorsIn(
      "# A title, of `two_parts`: x\n```\n# not one\n```\n    # nor this\n## Twice\n## Twice\n");
  EXPECT_EQ(anchors, (std::set<std::string>{"a-title-of-two_parts-x", "twice", "twice-1"}));
}

}  // namespace
