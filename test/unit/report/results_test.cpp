#include "report/results.hpp"
#include "report/descriptions.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "estimation/identification.hpp"
#include "support/base_drive.hpp"

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
