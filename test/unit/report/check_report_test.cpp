#include "report/results.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

Recording turnedRoundDrive() {
  Recording recording = test::toRecording(test::cleanDrive());
  recording.name = "drive.csv";
  for (double& current : recording.series.current) current = -current;
  recording.rejected.missing_value = 2;
  recording.offered += 2;
  recording.series.temperature_time = {0.0, 100.0};
  recording.series.temperature = {298.15, 300.15};
  return recording;
}

TEST(CheckReportJson, HoldsWhatTheReportHolds) {
  const Recording recording = turnedRoundDrive();
  const CheckReport report = checkRecording(recording);
  const nlohmann::json json = checkReportJson(recording, report);
  EXPECT_EQ(json.at("schema"), "battery_sof/check/1");
  EXPECT_EQ(json.at("recording"), "drive.csv");
  EXPECT_EQ(json.at("samples"), report.samples);
  EXPECT_EQ(json.at("from_s"), report.from);
  EXPECT_EQ(json.at("to_s"), report.to);
  EXPECT_EQ(json.at("median_interval_s"), report.median_interval);
  EXPECT_EQ(json.at("rejected").at("missing_value"), 2);
  EXPECT_EQ(json.at("rejected").at("clock_step_back"), 0);
  EXPECT_TRUE(json.at("voltage_lsb_v").is_null());
  EXPECT_NEAR(json.at("temperature_range_c")[1], 27.0, 1e-9);
  ASSERT_EQ(json.at("findings").size(), report.findings.size());
}

TEST(CheckReportJson, SaysWhoImposesWhat) {
  const Recording recording = test::toRecording(test::cleanDrive());
  const auto source = checkReportJson(recording, checkRecording(recording)).at("source");
  EXPECT_EQ(source.at("seen"), true);
  EXPECT_GE(source.at("share"), 0.0);
  EXPECT_LT(source.at("min_current_a"), 0.0);
  std::size_t samples = 0, stretches = 0;
  for (const auto& reason : source.at("reasons")) {
    samples += reason.at("samples").get<std::size_t>();
    stretches += reason.at("stretches").get<std::size_t>();
  }
  EXPECT_EQ(samples, recording.series.size());
  EXPECT_EQ(source.at("stretches"), stretches);
}

TEST(CheckReportJson, ARecordingWithoutChargesHasNoSource) {
  Recording recording;
  for (int k = 0; k < 200; ++k) {
    recording.series.time.push_back(k);
    recording.series.current.push_back(k % 20 < 5 ? -10.0 : 0.0);
    recording.series.voltage.push_back(k % 20 < 5 ? 12.3 : 12.4);
  }
  recording.offered = recording.series.size();
  const auto source = checkReportJson(recording, checkRecording(recording)).at("source");
  EXPECT_EQ(source.at("seen"), false);
  EXPECT_TRUE(source.at("min_current_a").is_null());
}

TEST(CheckReportJson, FindingHasAllItsFields) {
  const Recording recording = turnedRoundDrive();
  const auto json = checkReportJson(recording, checkRecording(recording));
  const auto& finding = json.at("findings").at(0);
  EXPECT_EQ(finding.at("id"), "sign");
  EXPECT_EQ(finding.at("severity"), "problem");
  for (const char* field : {"what", "meaning", "unit"}) EXPECT_TRUE(finding.at(field).is_string());
  EXPECT_TRUE(finding.at("value").is_number());
  EXPECT_TRUE(finding.at("samples").is_number());
  EXPECT_TRUE(finding.at("at_s").is_array());
}

TEST(CheckReportJson, CountsTheEvents) {
  const Recording recording = test::toRecording(test::cleanDrive());
  const auto events = checkReportJson(recording, checkRecording(recording)).at("events");
  EXPECT_GE(events.at("crank").at("count"), 3);
  EXPECT_GT(events.at("charge").at("duration_s"), 60.0);
  EXPECT_GT(events.at("charge_in_ah"), 0.0);
  EXPECT_LT(events.at("charge_out_ah"), 0.0);
  EXPECT_GT(events.at("charges_over_10_s"), 0);
  EXPECT_LT(events.at("charge_voltage_range_v")[0], events.at("charge_voltage_range_v")[1]);
}

TEST(CheckReportJson, AbsentNumbersAreNull) {
  Recording recording = test::toRecording({});
  recording.series.time = {0.0, 1.0};
  recording.series.current = {-5.0, -5.0};
  recording.series.voltage = {12.5, 12.5};
  const auto json = checkReportJson(recording, checkRecording(recording));
  EXPECT_TRUE(json.at("current_lsb_a").is_null());
  EXPECT_TRUE(json.at("temperature_range_c").is_null());
  EXPECT_TRUE(json.at("events").at("charge_voltage_range_v").is_null());
}

TEST(CheckReportText, SaysWhatIsInTheRecordingWhatWasFoundAndWhatItMeans) {
  const Recording recording = turnedRoundDrive();
  const CheckReport report = checkRecording(recording);
  const std::string text = checkReportText(recording, report);
  for (const std::string& part :
       {std::string("drive.csv\n"), std::string("(100 Hz)"), std::string("2 missing value"),
        std::string("25 degC to 27 degC"), std::string("charge"), std::string(" Ah in, "),
        std::string("problem"), std::string("sign: voltage falls when current rises"),
        std::string("--discharge-positive")}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in\n" << text;
  }
}

TEST(CheckReportText, HasNoLineOfMoreThanAHundredColumns) {
  const Recording recording = turnedRoundDrive();
  std::istringstream lines(checkReportText(recording, checkRecording(recording)));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << line;
}

TEST(CheckReportText, SaysThatNothingWasFound) {
  const Recording recording = test::toRecording(test::cleanDrive());
  const std::string text = checkReportText(recording, checkRecording(recording));
  EXPECT_NE(text.find("findings: none"), std::string::npos) << text;
}

TEST(CheckReportText, ListsWhatCouldNotBeJudged) {
  Series series = test::cleanDrive();
  series = slice(series, indexRange(series, 130.0, 600.0));
  const Recording recording = test::toRecording(series);
  const std::string text = checkReportText(recording, checkRecording(recording));
  EXPECT_NE(text.find("not judged\n    offset: no rest"), std::string::npos) << text;
}

}  // namespace
}  // namespace battery_sof
