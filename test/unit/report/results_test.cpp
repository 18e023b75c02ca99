#include "report/results.hpp"
#include "report/descriptions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "estimation/identification.hpp"
#include "recording/checks.hpp"
#include "recording/control_mode.hpp"
#include "support/base_drive.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

FittedModel fittedModel() {
  const Series series = test::baseDrive(1);
  return identify(series, {0, series.size()});
}

TEST(IdentifyJson, HoldsTheContractsFields) {
  const auto json = resultJson(fittedModel());
  EXPECT_EQ(json["schema"], "battery_sof/model/1");
  EXPECT_TRUE(json["window"]["from_s"].is_number());
  EXPECT_EQ(json["samples"], 24000);
  EXPECT_TRUE(json["effects"].is_array());
  EXPECT_EQ(json["status"], "converged");
  ASSERT_EQ(json["parameters"].size(), 5u);
  for (const auto& parameter : json["parameters"])
    for (const char* key : {"name", "value", "std_error", "unit", "at_bound", "determined"})
      EXPECT_TRUE(parameter.contains(key)) << key;
  for (const char* key : {"message", "q_dyn_percent", "rmse_v", "window_quality", "fit_ms"})
    EXPECT_TRUE(json.contains(key)) << key;
}

TEST(IdentifyText, SaysWhichParametersAreNotDetermined) {
  FittedModel model = fittedModel();
  model.fit.estimates[1].determined = false;
  model.fit.estimates[1].std.reset();
  EXPECT_NE(resultText(model).find("not determined"), std::string::npos);
}

TEST(IdentifyText, SaysWhoControlsTheVoltageAsTheCheckDoes) {
  const Recording recording{"drive", test::baseDrive(1), {}, 24000, 0.0};
  const ControlModes mode = detectControlMode(recording.series);
  const auto check = checkReportJson(recording, checkRecording(recording));
  EXPECT_EQ(check["source"]["summary"], mode.summary);
  const std::string first = mode.summary.substr(0, 40);
  EXPECT_NE(resultText(fittedModel(), mode).find("source       " + first), std::string::npos)
      << resultText(fittedModel(), mode);
}

TEST(CrankErrors, OfAWindowGoByOneNameInIdentifyAndPredict) {
  Series series = test::baseDrive(1);
  for (std::size_t n = 0; n < series.size(); ++n)  // what the equations do not hold
    if (series.current[n] < -100.0) series.voltage[n] -= 1e-5 * std::pow(series.current[n], 2);
  const FittedModel model = identify(series, {0, series.size()});
  ASSERT_GT(model.fit.scores.cranks, 1);
  const PredictionReport report = predictRange(model, series, {0, series.size()}).report;
  const double in_fit = model.fit.scores.crank_error_std;
  ASSERT_TRUE(report.from_current.crank_equations_rms);
  EXPECT_GT(in_fit, 0.03);
  EXPECT_NEAR(*report.from_current.crank_equations_rms, in_fit, 0.1 * in_fit);
  const std::string identified = resultText(model), predicted = resultText(report);
  EXPECT_NE(identified.find(
                format("the equations miss their lowest voltages by %.0f mV RMS", 1e3 * in_fit)),
            std::string::npos);
  EXPECT_NE(predicted.find("the answers miss their lowest voltages by"), std::string::npos);
  EXPECT_NE(predicted.find("the equations without correction by past cranks by "),
            std::string::npos);
  EXPECT_EQ(identified.find("missed by"), std::string::npos);
  EXPECT_EQ(predicted.find("missed by"), std::string::npos);
}

TEST(PredictionJson, HoldsTheContractsFieldsAndNullForWhatIsUndefined) {
  PredictionReport report;
  PredictionScores& scores = report.from_current;
  scores.cranks.push_back(
      {{PastEvent::Kind::kCrank, 12.0, 0.0, -200.0, 0.0, 0.0, 10.1}, {10.0, 9.8, 10.2}});
  const auto json = resultJson(report);
  EXPECT_EQ(json["schema"], "battery_sof/prediction/1");
  EXPECT_TRUE(json["q_dyn_percent"].is_null());
  EXPECT_TRUE(json["crank_mae_v"].is_null());
  for (const char* key : {"time_s", "measured_min_v", "predicted_min_v", "lower_v", "upper_v"})
    EXPECT_TRUE(json["cranks"][0].contains(key)) << key;
  EXPECT_TRUE(json["mixed"].is_null());
  EXPECT_TRUE(json["baseline"]["q_dyn_percent"].is_null());
  EXPECT_TRUE(json["baseline"]["rmse_v"].is_null());
}

TEST(CrankingJson, HoldsTheServicesFieldsAndNullForAbsentNumbers) {
  CrankingAnswer answer;
  answer.code = AnswerCode::kInvalidQuery;
  answer.message = "t_stop is -1";
  const auto json = jsonOf(answer);
  EXPECT_TRUE(json["u_min"].is_null());
  EXPECT_TRUE(json["capable"].is_null());
  EXPECT_EQ(json["valid"], false);
  EXPECT_EQ(json["code"], 1);
  EXPECT_EQ(json["message"], "t_stop is -1");
}

}  // namespace
}  // namespace battery_sof
