#include "util/files.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>

#include "support/commands.hpp"

namespace battery_sof {
namespace {

class RequireSeparateFiles : public test::InFolder {
 protected:
  RequireSeparateFiles() : InFolder("separate files") { input_ = write("in.csv", "x"); }

  static std::string refusal(const std::vector<std::string>& read,
                             const std::vector<std::string>& written) {
    try {
      requireSeparateFiles(read, written);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }

  std::string input_;
};

TEST_F(RequireSeparateFiles, AnInputUnderItsOwnNameOrAnotherIsRefused) {
  std::filesystem::create_symlink(input_, path("link.csv"));
  std::filesystem::create_hard_link(input_, path("hard.csv"));
  std::filesystem::create_directory_symlink(folder_, path("folder"));
  for (const char* name : {"in.csv", "./in.csv", "link.csv", "hard.csv", "folder/in.csv"}) {
    const std::string said = refusal({input_}, {path(name)});
    EXPECT_NE(said.find(path(name) + " would be written over " + input_), std::string::npos)
        << name << ": " << said;
  }
}

TEST_F(RequireSeparateFiles, TwoOutputsOfOneNameAreRefusedThoughNeitherIsThere) {
  EXPECT_NE(refusal({}, {path("new"), path("./new")}).find("are one file to write"),
            std::string::npos);
  std::filesystem::create_directory_symlink(folder_, path("folder"));
  EXPECT_NE(refusal({}, {path("new"), path("folder/new")}), "");
}

TEST_F(RequireSeparateFiles, OtherFilesDevicesAndStandardOutputAreAllowed) {
  EXPECT_EQ(refusal({input_, input_}, {path("a"), path("b"), ""}), "");
  EXPECT_EQ(refusal({input_}, {"-", "/dev/null", "/dev/null"}), "");
  std::filesystem::create_symlink("loop", path("loop"));
  EXPECT_EQ(refusal({input_}, {path("loop"), path(std::string(300, 'x'))}), "");
}

}  // namespace
}  // namespace battery_sof
