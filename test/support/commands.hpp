#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

/// What tests of commands share: what a command said, and a folder to work in.
namespace battery_sof::test {

struct Outcome {
  int code;
  std::string out, err;
};

/// @param command int(arguments, out, err).
template <typename Command>
Outcome outcomeOf(Command&& command, const std::vector<std::string>& arguments) {
  std::ostringstream out, err;
  const int code = command(arguments, out, err);
  return {code, out.str(), err.str()};
}

/// A folder with a space in its name that goes away with the test.
class InFolder : public testing::Test {
 protected:
  /// @param name reports the tests of one program apart.
  explicit InFolder(const std::string& name)
      : folder_(std::filesystem::temp_directory_path() /
                ("battery_sof " + name + " " + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~InFolder() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(path(name), std::ios::binary) << content;
    return path(name);
  }

  std::filesystem::path folder_;
};

}  // namespace battery_sof::test
