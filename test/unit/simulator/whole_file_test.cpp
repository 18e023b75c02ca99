#include "simulator/recording_output.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "support/commands.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof_simulator {
namespace {

namespace fs = std::filesystem;

const std::string kText(200000, 'x');

class WholeFile : public battery_sof::test::InFolder {
 protected:
  WholeFile() : InFolder("whole file") {}

  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }

  /// Writes new files without end.
  [[noreturn]] void writeOn(int round) const {
    for (int n = 0;; ++n)
      writeText(path("file " + std::to_string(round) + " " + std::to_string(n)), kText);
  }
};

/// Fifty processes that write without end are killed at random moments.
TEST_F(WholeFile, AKilledProcessLeavesWholeFilesAndNothingElse) {
  battery_sof::test::Random random(12);
  for (int round = 0; round < 50; ++round) {
    const pid_t child = ::fork();
    if (child == 0) writeOn(round);
    std::this_thread::sleep_for(
        std::chrono::microseconds(static_cast<long>(random.uniform(0.0, 20000.0))));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }
  EXPECT_GT(files(), 50u);
  for (const auto& entry : fs::directory_iterator(folder_)) {
    EXPECT_EQ(entry.path().filename().string().rfind("file ", 0), 0u) << entry.path();
    EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
    EXPECT_EQ(entry.file_size(), kText.size()) << entry.path();
  }
}

TEST_F(WholeFile, WritingThatFailsLeavesTheOldFileAsItWas) {
  writeText(path("file"), "old");
  EXPECT_THROW(writeWhole(path("file"),
                          [](const fs::path& name) {
                            std::ofstream(name) << "half";
                            throw std::runtime_error("no more");
                          }),
               std::runtime_error);
  std::string content;
  std::ifstream(path("file")) >> content;
  EXPECT_EQ(content, "old");
  EXPECT_EQ(files(), 1u);
}

TEST_F(WholeFile, AnOldFileIsReplaced) {
  writeText(path("file"), "old");
  writeText(path("file"), "new");
  std::string content;
  std::ifstream(path("file")) >> content;
  EXPECT_EQ(content, "new");
  EXPECT_EQ(files(), 1u);
}

TEST_F(WholeFile, WithoutAFolderItIsSaidSo) {
  try {
    writeText(path("none/file"), "text");
    FAIL() << "a file was written without a folder";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("none/file: cannot be written"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace battery_sof_simulator
