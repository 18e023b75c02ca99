#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "bag/bag_storage.hpp"
#include "support/drive_in_folder.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

using test::sof;

using BagCommands = test::DriveInFolder;

TEST_F(BagCommands, RefusesATruncatedBag) {
  writeBag(path("whole.bag"), test::baseDrive(1, 20.0));
  fs::copy_file(path("whole.bag"), path("truncated.bag"));
  fs::resize_file(path("truncated.bag"), fs::file_size(path("whole.bag")) / 2);
  expectRefused(path("truncated.bag"), {"truncated.bag"});
}

TEST_F(BagCommands, RefusesABagWithoutTheTopicAndListsItsTopics) {
  writeBag(path("other.bag"), test::baseDrive(1, 1.0), "starter_battery");
  expectRefused(path("other.bag"), {"battery_state", "starter_battery"});
  EXPECT_EQ(sof({"check", path("other.bag"), "--topic", "starter_battery"}).code, 0);
}

TEST_F(BagCommands, KnowsABagUnderAnotherNameByItsFirstBytes) {
  expectRefused(write("drive.csv", "#ROSBAG V2.0\n"), {"drive.csv", "damaged bag"});
}

TEST_F(BagCommands, ConvertsToABagAndBackWithoutChangingASample) {
  ASSERT_EQ(sof({"convert", inputs_, path("drive.bag")}).code, 0);
  ASSERT_EQ(sof({"convert", path("drive.bag"), path("back.csv")}).code, 0);
  const Series before = readCsv(inputs_).series, after = readCsv(path("back.csv")).series;
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t n = 0; n < before.size(); ++n) {
    EXPECT_NEAR(after.time[n], before.time[n], 1e-9);
    EXPECT_NEAR(after.current[n], before.current[n], 3e-5);  // single precision in the message
    EXPECT_NEAR(after.voltage[n], before.voltage[n], 1e-6);
  }
}

TEST_F(BagCommands, GivesTheSameModelForABagAsForItsCsv) {
  ASSERT_EQ(sof({"convert", inputs_, path("drive.bag")}).code, 0);
  const auto fit = [&](const std::string& file) {
    return nlohmann::json::parse(
        sof({"identify", file, "--from", "0", "--to", "240", "--out", model_, "--json", "-"}).out);
  };
  const auto csv = fit(inputs_), bag = fit(path("drive.bag"));
  for (std::size_t j = 0; j < 5; ++j)
    EXPECT_NEAR(bag["parameters"][j]["value"].get<double>(),
                csv["parameters"][j]["value"].get<double>(),
                1e-5 * csv["parameters"][j]["value"].get<double>());
}

}  // namespace
}  // namespace battery_sof
