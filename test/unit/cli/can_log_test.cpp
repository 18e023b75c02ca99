#include "cli/can_log.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "support/drive_in_folder.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

using test::sof;

constexpr char kDbc[] =
    "BO_ 704 Battery: 8 Sensor\n"
    " SG_ Current : 0|16@1- (0.1,0) [-3276.8|3276.7] \"A\" Vector__XXX\n"
    " SG_ Voltage : 23|16@0+ (1,0) [0|65535] \"mV\" Vector__XXX\n";

/// Stands in for python-can: a frame of -20 A and 12500 mV every second.
constexpr char kPythonCan[] =
    "import types\n"
    "io = types.SimpleNamespace()\n"
    "def LogReader(log):\n"
    "    for k in range(5):\n"
    "        yield types.SimpleNamespace(timestamp=float(k), arbitration_id=704, "
    "is_extended_id=False,\n"
    "            data=bytes([0x38, 0xFF, 0x30, 0xD4, 0, 0, 0, 0]), is_error_frame=False,\n"
    "            is_remote_frame=False)\n";

/// A log whose name and first bytes are a BLF file's, and a Python path of one folder.
class CanLog : public test::DriveInFolder {
 protected:
  void SetUp() override {
    log_ = write("trip.blf", "LOGG and more");
    dbc_ = write("vehicle.dbc", kDbc);
    const std::string scripts = BATTERY_SOF_SOURCE_DIR "/scripts";
    ::setenv("PATH", (scripts + ":" + std::getenv("PATH")).c_str(), 1);
    ::setenv("PYTHONPATH", path("").c_str(), 1);
  }
  void TearDown() override { ::unsetenv("PYTHONPATH"); }

  test::Outcome convert(const std::vector<std::string>& more) const {
    std::vector<std::string> call = {"convert", log_, path("out.csv"), "--dbc", dbc_};
    call.insert(call.end(), more.begin(), more.end());
    return sof(call);
  }

  std::string log_, dbc_;
};

TEST_F(CanLog, IsNamedByEveryCommandWithTheOneThatConvertsIt) {
  expectRefused(log_, {"trip.blf: is a log of a CAN bus", "sof convert", "--dbc FILE.dbc"});
  expectRefused(write("trip.mf4", "MDF     4.10"), {"is a log of a CAN bus"});
  expectRefused(write("trip.asc", "date Mon Sep 30 15:06:13 2013\n"), {"is a log of a CAN bus"});
}

TEST_F(CanLog, IsToldFromOtherFilesByItsBytes) {
  EXPECT_TRUE(isCanLog(log_));
  EXPECT_FALSE(isCanLog(inputs_));
  EXPECT_FALSE(isCanLog(write("export.asc", "time_s,current_a,voltage_v\n0,1,12\n")));
  EXPECT_FALSE(isCanLog(path("absent.blf")));
}

TEST_F(CanLog, IsConvertedByTheSignalsOfItsDbcFile) {
  write("can.py", kPythonCan);
  const auto done = convert({"--current-column", "Battery.Current", "--voltage-column", "Voltage",
                             "--discharge-positive"});
  ASSERT_EQ(done.code, 0) << done.err;
  const Series series = readCsv(path("out.csv")).series;
  ASSERT_EQ(series.size(), 5U);
  EXPECT_EQ(series.time[1], 1.0);
  EXPECT_EQ(series.current[1], 20.0);
  EXPECT_EQ(series.voltage[1], 12.5);
}

TEST_F(CanLog, IsRefusedWithWhatIsMissing) {
  const auto unnamed = convert({"--current-column", "Current"});
  EXPECT_EQ(unnamed.code, 2);
  EXPECT_NE(unnamed.err.find("expected --current-column and --voltage-column too"),
            std::string::npos)
      << unnamed.err;
  write("can.py", "raise ImportError\n");
  const auto without =
      convert({"--current-column", "Battery.Current", "--voltage-column", "Voltage"});
  EXPECT_EQ(without.code, 2);
  EXPECT_NE(without.err.find("trip.blf: can_log: needs python3-can"), std::string::npos)
      << without.err;
  write("can.py", kPythonCan);
  const auto unknown = convert({"--current-column", "Amps", "--voltage-column", "Voltage"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.err.find("signal Amps is not in the DBC file"), std::string::npos)
      << unknown.err;
  EXPECT_FALSE(fs::exists(path("out.csv")));
}

}  // namespace
}  // namespace battery_sof
