#include "ros/state_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "prediction/online_session.hpp"
#include "report/model_yaml.hpp"
#include "support/base_drive.hpp"
#include "support/commands.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

class StateFileTest : public test::InFolder {
 protected:
  StateFileTest() : InFolder("state file") {}

  static StateFile::Result resultOf(const std::string& file) {
    StateFile::Result result = StateFile(file).read();
    EXPECT_FALSE(result.model);
    return result;
  }
};

TEST_F(StateFileTest, KeepsWhatASessionLearntBeforeAWindowWasFitted) {
  OnlineSession session, next;
  const Series drive = test::answered(test::drivenBattery(),
                                      test::dataSetOneCurrent(100.0, 0.05, 3), 0.05, 0.002, 3);
  for (std::size_t n = 0; n < drive.size(); ++n)
    session.push({drive.time[n], drive.current[n], drive.voltage[n], 298.0});
  const StateFile file(path("model.yaml"));
  ASSERT_TRUE(session.modelToSave());
  const StateFile::Result saved = file.save(*session.modelToSave());
  EXPECT_FALSE(saved.is_fault) << saved.said;
  const StateFile::Result read = file.read();
  ASSERT_TRUE(read.model) << read.said;
  next.restore(*read.model);
  next.push({drive.time.back() + 3600.0, -5.0, 12.5, {}});
  EXPECT_EQ(next.status().basis, AnswerBasis::kPreviousTrip) << next.status().reason;
  EXPECT_EQ(read.model->intervals.calibrations.cranks.factor, session.calibrations().cranks.factor);
}

TEST_F(StateFileTest, KeepsAModelFromOneRunToTheNext) {
  const StateFile file(path("new folder/model.yaml"));
  EXPECT_FALSE(file.save(test::uncertainModel(0.02)).is_fault);
  const StateFile::Result result = file.read();
  ASSERT_TRUE(result.model);
  EXPECT_FALSE(result.is_fault);
  EXPECT_FALSE(resultOf(path("absent.yaml")).is_fault);
  EXPECT_FALSE(resultOf("").is_fault);
}

TEST_F(StateFileTest, ARefusedFileIsSetAsideWithTheReasonAndNotReadAgain) {
  write("model.yaml", "schema: battery_sof/model/2\neffects: 7\n");
  const StateFile::Result result = resultOf(path("model.yaml"));
  EXPECT_TRUE(result.is_fault);
  EXPECT_NE(result.said.find("effects is \"7\""), std::string::npos) << result.said;
  EXPECT_NE(result.said.find("it was set aside as " + path("model.yaml.refused")),
            std::string::npos)
      << result.said;
  EXPECT_FALSE(fs::exists(path("model.yaml")));
  EXPECT_TRUE(fs::exists(path("model.yaml.refused")));
  EXPECT_FALSE(resultOf(path("model.yaml")).is_fault);
}

TEST_F(StateFileTest, EachRefusedFileIsKept) {
  for (const std::string text : {"first", "second", "third"}) {
    write("model.yaml", text);
    EXPECT_TRUE(resultOf(path("model.yaml")).is_fault);
  }
  EXPECT_EQ(fs::file_size(path("model.yaml.refused")), 5u);
  EXPECT_EQ(fs::file_size(path("model.yaml.refused.1")), 6u);
  EXPECT_EQ(fs::file_size(path("model.yaml.refused.2")), 5u);
}

TEST_F(StateFileTest, ALinkStaysAndTheFileItNamesIsWrittenAndSetAside) {
  fs::create_directory(path("kept"));
  fs::create_symlink("kept/model.yaml", path("link.yaml"));
  const StateFile file(path("link.yaml"));
  EXPECT_FALSE(resultOf(path("link.yaml")).is_fault);
  EXPECT_FALSE(file.save(test::uncertainModel(0.02)).is_fault);
  EXPECT_TRUE(fs::exists(path("kept/model.yaml")));
  file.setAside();
  EXPECT_TRUE(fs::exists(path("kept/model.yaml.refused")));
  EXPECT_FALSE(fs::exists(path("kept/model.yaml")));
  fs::remove_all(path("kept"));
  const StateFile::Result result = file.save(test::uncertainModel(0.02));
  EXPECT_THAT(result.said, testing::HasSubstr("No such file or directory"));
  EXPECT_TRUE(fs::is_symlink(path("link.yaml")));
}

TEST_F(StateFileTest, WhatIsNoRegularFileIsNeitherReadNorMovedNorWritten) {
  fs::create_symlink("loop", path("loop"));
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  for (const std::string& file : {path("loop"), path("pipe"), folder_.string(),
                                  std::string("/dev/null"), path(std::string(300, 'x'))}) {
    EXPECT_TRUE(resultOf(file).is_fault) << file;
    EXPECT_TRUE(StateFile(file).save(test::uncertainModel(0.02)).is_fault) << file;
    std::error_code ignored;
    EXPECT_FALSE(fs::exists(fs::symlink_status(file + ".refused", ignored))) << file;
  }
}

TEST_F(StateFileTest, AModelThatCouldNotBeReadBackIsNotSaved) {
  FittedModel model = test::uncertainModel(0.02);
  model.state.states[0] = std::nan("");
  EXPECT_TRUE(StateFile(path("model.yaml")).save(model).is_fault);
  EXPECT_FALSE(fs::exists(path("model.yaml")));
}

TEST_F(StateFileTest, DraftsOfProcessesThatAreGoneAreRemoved) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ::waitpid(child, nullptr, 0);
  write(".model.yaml." + std::to_string(child) + "-0", "half");
  write(".model.yaml." + std::to_string(::getpid()) + "-7", "being written");
  write(".model.yaml.txt", "someone else's");
  resultOf(path("model.yaml"));
  EXPECT_FALSE(fs::exists(path(".model.yaml." + std::to_string(child) + "-0")));
  EXPECT_TRUE(fs::exists(path(".model.yaml." + std::to_string(::getpid()) + "-7")));
  EXPECT_TRUE(fs::exists(path(".model.yaml.txt")));
}

/// A hundred processes that save without end are killed at random moments: the file is whole each
/// time.
TEST_F(StateFileTest, IsWholeWheneverTheProcessIsKilled) {
  const StateFile file(path("model.yaml"));
  ASSERT_FALSE(file.save(test::uncertainModel(0.01)).is_fault);
  test::Random random(11);
  for (int round = 0; round < 100; ++round) {
    const pid_t child = ::fork();
    if (child == 0)
      for (double share = 0.01;; share = share < 0.3 ? share + 0.01 : 0.01)
        file.save(test::uncertainModel(share));
    std::this_thread::sleep_for(
        std::chrono::microseconds(static_cast<long>(random.uniform(0.0, 20000.0))));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const StateFile::Result result = file.read();
    ASSERT_TRUE(result.model) << "round " << round << ": " << result.said;
  }
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder_)) files += entry.is_regular_file();
  EXPECT_EQ(files, 1u) << "no draft is left";
}

}  // namespace
}  // namespace battery_sof
