#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/sof.hpp"
#include "support/drive_in_folder.hpp"

/// --series-blocks: a series string is checked, identified and diagnosed as one block, and answered
/// for in its own volts.
namespace battery_sof {
namespace {

using test::Outcome;
using test::sof;
using Json = nlohmann::json;

class SeriesBlocksOption : public test::DriveInFolder {
 protected:
  SeriesBlocksOption() {
    Series series = test::baseDrive(1, 300.0);
    for (double& voltage : series.voltage) voltage *= 2.0;
    row_inputs_ = path("row.csv");
    row_model_ = path("row.yaml");
    writeCsv(row_inputs_, series);
  }

  /// What a command says as JSON.
  static Json told(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--json", "-"});
    const Outcome outcome = sof(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.code == 0 ? Json::parse(outcome.out) : Json();
  }

  std::string row_inputs_, row_model_;
};

TEST_F(SeriesBlocksOption, IdentifiesTheSameBlockAndAnswersWithTwiceTheVoltage) {
  const Json one = told({"identify", inputs_, "--out", model_}),
             row = told({"identify", row_inputs_, "--out", row_model_, "--series-blocks", "2"});
  EXPECT_EQ(one["series_blocks"], 1.0);
  EXPECT_EQ(row["series_blocks"], 2.0);
  EXPECT_EQ(row["parameters"], one["parameters"]);
  EXPECT_EQ(row["window_quality"], one["window_quality"]);
  const auto crank = [&](const std::string& model, const std::string& u_required) {
    return told({"crank", model, "--i-load", "-20", "--t-stop", "30", "--i-cranking", "-200",
                 "--u-required", u_required});
  };
  const Json of_one = crank(model_, "7.2"), of_row = crank(row_model_, "14.4");
  for (const char* number : {"u_min", "lower", "upper"})
    EXPECT_EQ(of_row[number].get<double>(), 2.0 * of_one[number].get<double>());
  EXPECT_EQ(of_row["capable"], of_one["capable"]);
  const auto charge = [&](const std::string& model, const std::string& u_boost) {
    return told({"charge", model, "--u-boost", u_boost});
  };
  EXPECT_EQ(charge(row_model_, "26.4")["i_boost"], charge(model_, "13.2")["i_boost"]);
}

TEST_F(SeriesBlocksOption, PredictsARecordingOfTheRow) {
  told({"identify", inputs_, "--out", model_});
  told({"identify", row_inputs_, "--out", row_model_, "--series-blocks", "2"});
  const Json one = told({"predict", model_, inputs_}),
             row = told({"predict", row_model_, row_inputs_, "--csv", path("row_out.csv")});
  EXPECT_EQ(row["q_dyn_percent"], one["q_dyn_percent"]);
  EXPECT_EQ(row["rmse_v"].get<double>(), 2.0 * one["rmse_v"].get<double>());
  std::ifstream csv(path("row_out.csv"));
  std::string header, first;
  std::getline(csv, header);
  std::getline(csv, first);
  double time = 0.0, current = 0.0, measured = 0.0, predicted = 0.0;
  ASSERT_EQ(std::sscanf(first.c_str(), "%lf,%lf,%lf,%lf", &time, &current, &measured, &predicted),
            4)
      << first;
  EXPECT_NEAR(measured, 25.4, 2.0);
  EXPECT_NEAR(predicted, measured, 0.5);
}

TEST_F(SeriesBlocksOption, IsCheckedAndDiagnosedWithoutAWarningOfItsVoltage) {
  EXPECT_NE(sof({"check", row_inputs_}).out.find("(--series-blocks 2)"), std::string::npos);
  EXPECT_NE(
      sof({"identify", row_inputs_, "--out", row_model_}).err.find("not a 12 V lead-acid block"),
      std::string::npos);
  const Outcome checked = sof({"check", row_inputs_, "--series-blocks", "2"});
  EXPECT_EQ(checked.out.find("not a 12 V lead-acid block"), std::string::npos) << checked.out;
  EXPECT_EQ(checked.out.find(
                "2 blocks of 12 V in series: volts and ohms reported here are those of one block"),
            0u)
      << checked.out;
  EXPECT_EQ(sof({"identify", row_inputs_, "--out", row_model_, "--series-blocks", "2"}).err, "");
  const Json one = told({"diagnose", inputs_}),
             row = told({"diagnose", row_inputs_, "--series-blocks", "2"});
  EXPECT_EQ(row["verdict"], one["verdict"]);
  EXPECT_EQ(row["summary"], one["summary"]);
  EXPECT_NE(row["instrument"].dump().find("2 blocks of 12 V in series"), std::string::npos);
}

TEST_F(SeriesBlocksOption, RefusesWhatIsNoRow) {
  for (const char* command : {"check", "identify", "diagnose"}) {
    std::vector<std::string> call = {command, inputs_, "--series-blocks", "0.3"};
    if (call[0] == "identify") call.insert(call.end(), {"--out", model_});
    const Outcome outcome = sof(call);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find("--series-blocks is 0.3, expected 0.5 (6 V), 1 (12 V), 2 (24 V), 4 "
                               "(48 V) or another multiple of 0.5 up to 6"),
              std::string::npos)
        << outcome.err;
  }
  EXPECT_EQ(sof({"check", inputs_, "--series-blocks", "two"}).code, 2);
}

}  // namespace
}  // namespace battery_sof
