#include "util/files.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <stdexcept>

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

class AtomicFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("atomic file ") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::string content(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  std::ptrdiff_t filesInFolder() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }

  fs::path folder_;
};

TEST_F(AtomicFile, HoldsExactlyTheContentAndNothingElseIsInTheFolder) {
  const std::string text("a\r\n\0b", 5);
  writeFileAtomically(folder_ / "file.txt", text);
  EXPECT_EQ(content(folder_ / "file.txt"), text);
  EXPECT_EQ(filesInFolder(), 1);
}

TEST_F(AtomicFile, ReplacesAnExistingFile) {
  writeFileAtomically(folder_ / "file.txt", "a long old content");
  writeFileAtomically(folder_ / "file.txt", "new");
  EXPECT_EQ(content(folder_ / "file.txt"), "new");
  EXPECT_EQ(filesInFolder(), 1);
}

TEST_F(AtomicFile, ReplacesTheTargetOfALinkAndKeepsTheLink) {
  writeFileAtomically(folder_ / "target.txt", "old");
  fs::create_symlink(folder_ / "target.txt", folder_ / "link.txt");
  writeFileAtomically(folder_ / "link.txt", "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.txt"));
  EXPECT_EQ(content(folder_ / "target.txt"), "new");
}

TEST_F(AtomicFile, WritesTheMissingTargetOfALinkAndKeepsTheLinks) {
  fs::create_directory(folder_ / "there");
  fs::create_symlink("there/second.txt", folder_ / "first.txt");
  fs::create_symlink("target.txt", folder_ / "there" / "second.txt");
  writeFileAtomically(folder_ / "first.txt", "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "first.txt"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "there" / "second.txt"));
  EXPECT_EQ(content(folder_ / "there" / "target.txt"), "new");
}

TEST_F(AtomicFile, ALinkIntoAMissingFolderIsKeptAndTheReasonSaid) {
  fs::create_symlink(folder_ / "missing" / "file.txt", folder_ / "link.txt");
  EXPECT_THROW(writeFileAtomically(folder_ / "link.txt", "x"), std::runtime_error);
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.txt"));
  EXPECT_EQ(filesInFolder(), 1);
}

TEST_F(AtomicFile, ALoopOfLinksIsKeptAndTheReasonSaid) {
  fs::create_symlink("loop", folder_ / "loop");
  EXPECT_THROW(writeFileAtomically(folder_ / "loop", "x"), std::runtime_error);
  EXPECT_TRUE(fs::is_symlink(folder_ / "loop"));
}

TEST_F(AtomicFile, WritingOntoAFolderFailsAndLeavesNothingBehind) {
  fs::create_directory(folder_ / "taken");
  EXPECT_THROW(writeFileAtomically(folder_ / "taken", "x"), std::runtime_error);
  EXPECT_EQ(filesInFolder(), 1);
  EXPECT_TRUE(fs::is_directory(folder_ / "taken"));
}

TEST_F(AtomicFile, WritingIntoAMissingFolderFailsNamingThePathAndTheReason) {
  try {
    writeFileAtomically(folder_ / "missing" / "file.txt", "x");
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find((folder_ / "missing" / "file.txt").string()), std::string::npos);
    EXPECT_NE(message.find("No such file or directory"), std::string::npos) << message;
  }
  EXPECT_EQ(filesInFolder(), 0);
}

TEST_F(AtomicFile, ContentThatCannotBeWrittenWholeFailsWithTheSystemsReason) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  try {
    writeFileAtomically("/dev/full", "x");
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("No space left"), std::string::npos) << error.what();
  }
}

TEST_F(AtomicFile, DeviceIsWrittenToAndNotReplaced) {
  writeFileAtomically("/dev/null", "x");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace battery_sof
