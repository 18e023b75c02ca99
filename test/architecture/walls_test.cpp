#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
const fs::path kRoot = BATTERY_SOF_SOURCE_DIR;
const fs::path kBenchmark = kRoot / "benchmark";

/// Stages in the order of the data flow: each may include itself and those before it.
const std::vector<std::string> kStages = {"util",      "recording", "model",      "regression",
                                          "baseline",  "state",     "estimation", "prediction",
                                          "diagnosis", "report"};

const std::regex kRosHeader(
    R"((/ros/|/rosbag/|/rosbag_storage/|/[a-z_]+_msgs/)[A-Za-z_]+\.(h|hpp))");

std::vector<fs::path> sourcesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const auto extension = entry.path().extension();
    if (extension == ".cpp" || extension == ".hpp") files.push_back(entry.path());
  }
  return files;
}

std::vector<fs::path> sourcesOf(const std::string& stage) {
  return sourcesIn(kRoot / "src" / stage);
}

std::vector<std::string> includesOf(const fs::path& file) {
  std::vector<std::string> includes;
  std::ifstream in(file);
  const std::regex pattern(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  for (std::string line; std::getline(in, line);) {
    std::smatch match;
    if (std::regex_search(line, match, pattern)) includes.push_back(match[1]);
  }
  return includes;
}

/// Everything a translation unit reads, as the preprocessor sees it.
std::string preprocessorDependencies(const fs::path& file) {
  const std::string command = std::string(BATTERY_SOF_CXX) + " -std=c++17 -M -x c++ -I\"" +
                              (kRoot / "include").string() + "\" -I\"" + (kRoot / "src").string() +
                              "\" -isystem \"" + BATTERY_SOF_EIGEN_DIR + "\" \"" + file.string() +
                              "\" 2>&1";
  std::string output;
  std::array<char, 4096> buffer{};
  FILE* pipe = popen(command.c_str(), "r");
  while (pipe != nullptr && std::fgets(buffer.data(), buffer.size(), pipe) != nullptr)
    output += buffer.data();
  EXPECT_EQ(pipe != nullptr ? pclose(pipe) : -1, 0) << command << "\n" << output;
  return output;
}

TEST(Architecture, EveryStageIsFound) {
  for (const auto& stage :
       {"recording", "baseline", "model", "state", "estimation", "prediction", "report"})
    EXPECT_GT(sourcesOf(stage).size(), 2u) << stage;
}

TEST(Architecture, NoStageIncludesALaterOne) {
  for (std::size_t stage = 0; stage < kStages.size(); ++stage)
    for (const auto& file : sourcesOf(kStages[stage]))
      for (const auto& include : includesOf(file))
        for (std::size_t later = stage + 1; later < kStages.size(); ++later)
          EXPECT_NE(include.rfind(kStages[later] + "/", 0), 0u)
              << file << " (" << kStages[stage] << ") includes " << include;
}

TEST(Architecture, TheCoreReadsNoRosHeaderAtAll) {
  // A stage's sources as one file: what they share is read once.
  const fs::path all = fs::temp_directory_path() / "battery_sof_wall_of_a_stage.cpp";
  for (const auto& stage : kStages) {
    std::ofstream text(all);
    for (const auto& file : sourcesIn(kRoot / "src" / stage))
      if (file.extension() == ".cpp") text << "#include \"" << file.string() << "\"\n";
    text.close();
    std::smatch match;
    const std::string dependencies = preprocessorDependencies(all);
    EXPECT_FALSE(std::regex_search(dependencies, match, kRosHeader))
        << "a source of " << stage << " reads " << match.str();
  }
  fs::remove(all);
}

TEST(Architecture, BagsAndTheCommandNameNoRosHeader) {
  for (const auto& folder : {"src/bag", "src/cli", "benchmark/simulator", "python"})
    for (const auto& file : sourcesIn(kRoot / folder))
      for (const auto& include : includesOf(file))
        EXPECT_FALSE(std::regex_search("/" + include, kRosHeader)) << file << ": " << include;
}

TEST(Architecture, TheFormatOfBagsReadsNothingOfTheCore) {
  for (const auto& file : sourcesOf("bag/format"))
    for (const auto& include : includesOf(file))
      EXPECT_TRUE(include.rfind("bag/format/", 0) == 0 ||
                  include == "battery_sof/recording_error.hpp" ||
                  !fs::exists(kRoot / "src" / include))
          << file << " includes " << include;
}

TEST(Architecture, TheWallWouldSeeARosHeader) {
  // The guard above must be able to fail: a file that does read a ROS header is seen.
  const fs::path file = fs::temp_directory_path() / "battery_sof_wall_test.cpp";
  std::ofstream(file) << "#include <ros/time.h>\n";
  EXPECT_TRUE(std::regex_search(preprocessorDependencies(file), kRosHeader));
  fs::remove(file);
}

TEST(Architecture, OnlyReportReadsJsonAndYaml) {
  for (const auto& stage :
       {"recording", "baseline", "model", "state", "estimation", "prediction", "diagnosis"})
    for (const auto& file : sourcesOf(stage))
      for (const auto& include : includesOf(file)) {
        EXPECT_EQ(include.find("nlohmann"), std::string::npos) << file;
        EXPECT_EQ(include.find("yaml"), std::string::npos) << file;
      }
}

TEST(Architecture, PublicHeadersAreFewAndReadNoOthers) {
  const auto headers = sourcesIn(kRoot / "include");
  EXPECT_LE(headers.size(), 25u);
  for (const auto& header : headers)
    for (const auto& include : includesOf(header))
      EXPECT_TRUE(include.rfind("battery_sof/", 0) == 0 || include.find('/') == std::string::npos)
          << header << " includes " << include;
}

TEST(Architecture, TheSimulatorIncludesNothingOfTheProductButTheFormatOfBags) {
  ASSERT_FALSE(sourcesIn(kBenchmark / "simulator").empty());
  for (const auto& file : sourcesIn(kBenchmark / "simulator"))
    for (const auto& include : includesOf(file)) {
      const bool own = (include.rfind("simulator/", 0) == 0 && fs::exists(kBenchmark / include)) ||
                       include.rfind("bag/format/", 0) == 0;
      EXPECT_TRUE(own || !(fs::exists(kRoot / include) || fs::exists(kRoot / "src" / include) ||
                           fs::exists(kRoot / "include" / include)))
          << file << " includes " << include;
    }
}

TEST(Architecture, NothingOfTheProductIncludesTheSimulator) {
  for (const auto& folder : {"src", "include", "python"})
    for (const auto& file : sourcesIn(kRoot / folder)) {
      if (file.filename() == "sof_main.cpp") continue;  // the program puts the two side by side
      for (const auto& include : includesOf(file))
        EXPECT_EQ(include.find("simulator/"), std::string::npos) << file << " includes " << include;
    }
}

TEST(Architecture, MainFilesOnlyWire) {
  auto files = sourcesIn(kRoot / "src");
  for (const auto& file : sourcesIn(kBenchmark / "simulator")) files.push_back(file);
  for (const auto& file : files) {
    if (file.string().find("_main.cpp") == std::string::npos) continue;
    std::ifstream in(file);
    int lines = 0;
    for (std::string line; std::getline(in, line);) ++lines;
    EXPECT_LT(lines, 60) << file;
  }
}

TEST(Architecture, TheCoreNeitherPrintsNorReadsAClock) {
  const std::regex forbidden(
      R"((std::cout|std::cerr|\bprintf\(|fprintf\(|system_clock|steady_clock|\btime\(nullptr))");
  for (const auto& stage : kStages)
    for (const auto& file : sourcesOf(stage)) {
      std::ifstream in(file);
      for (std::string line; std::getline(in, line);)
        EXPECT_FALSE(std::regex_search(line, forbidden)) << file << ": " << line;
    }
}

}  // namespace
