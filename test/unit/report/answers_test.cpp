#include "report/descriptions.hpp"
#include "report/results.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "support/known_model.hpp"

namespace battery_sof {
namespace {

using test::holds;
using test::knownModel;

constexpr double kEver = std::numeric_limits<double>::infinity();

StopTimeAnswer answered(StopTimeOutcome outcome, const Interval& t_stop) {
  StopTimeAnswer answer;
  answer.outcome = outcome;
  answer.t_stop = t_stop;
  answer.valid = true;
  answer.message = "said";
  return answer;
}

TEST(StopTimeJson, HoldsTheServicesFields) {
  const auto json = jsonOf(answered(StopTimeOutcome::kFinite, {30.0, 20.0, kEver}));
  EXPECT_EQ(json["t_stop"], 30.0);
  EXPECT_EQ(json["lower"], 20.0);
  EXPECT_TRUE(json["upper"].is_null());
  EXPECT_EQ(json["outcome"], "finite");
  EXPECT_EQ(json["monotone"], true);
  EXPECT_EQ(json["valid"], true);
  EXPECT_EQ(json["code"], 0);
  EXPECT_EQ(json["message"], "said");
}

TEST(StopTimeJson, InfiniteIsNullWithTheOutcomeAlwaysAndTheDocumentParses) {
  const auto json = jsonOf(answered(StopTimeOutcome::kAlways, {kEver, 50.0, kEver}));
  EXPECT_TRUE(json["t_stop"].is_null());
  EXPECT_EQ(json["outcome"], "always");
  EXPECT_EQ(nlohmann::json::parse(json.dump()), json);
}

TEST(StopTimeJson, WithoutAnAnswerEverythingButTheVerdictIsNull) {
  StopTimeAnswer none;
  none.code = AnswerCode::kNoModel;
  const auto json = jsonOf(none);
  for (const char* field : {"t_stop", "lower", "upper", "outcome", "monotone"})
    EXPECT_TRUE(json[field].is_null()) << field;
  EXPECT_EQ(json["code"], 2);
}

TEST(ChargeAcceptanceJson, HoldsTheServicesFieldsAndNullForAbsentNumbers) {
  ChargeAcceptanceAnswer answer;
  answer.i_boost = Interval{50.0, 40.0, 60.0};
  EXPECT_EQ(jsonOf(answer)["i_boost"], 50.0);
  EXPECT_EQ(jsonOf(answer)["upper"], 60.0);
  EXPECT_TRUE(jsonOf(ChargeAcceptanceAnswer{})["i_boost"].is_null());
  EXPECT_EQ(jsonOf(ChargeAcceptanceAnswer{})["valid"], false);
}

MapResult bothMaps() {
  CrankingQuery crank;
  crank.i_cranking = -200.0;
  MapResult result{{-10.0, -30.0}, {0.0, 3600.0}, {}, {13.0}, {1.0, 10.0}, {}};
  result.cranking = mapCranking(knownModel(), crank, result.i_load, result.t_stop);
  result.charge = mapChargeAcceptance(knownModel(), {}, result.u_boost, result.t_sof2);
  return result;
}

TEST(MapJson, HoldsListsAndAnswersRowByRow) {
  const auto json = jsonOf(bothMaps());
  EXPECT_EQ(json["schema"], "battery_sof/map/1");
  EXPECT_EQ(json["t_stop"], (std::vector<double>{0.0, 3600.0}));
  for (const char* field : {"u_min", "u_min_lower", "u_min_upper", "u_min_code", "capable"})
    EXPECT_EQ(json[field].size(), 4u) << field;
  for (const char* field : {"i_boost", "i_boost_lower", "i_boost_upper", "i_boost_code"})
    EXPECT_EQ(json[field].size(), 2u) << field;
  EXPECT_EQ(json["u_min_code"], (std::vector<int>{0, 3, 0, 3}));
  EXPECT_EQ(json["code"], 3);
  EXPECT_TRUE(json["capable"][0].is_null());
}

TEST(MapJson, LeavesOutTheMapThatWasNotAsked) {
  MapResult result = bothMaps();
  result.cranking.reset();
  const auto json = jsonOf(result);
  EXPECT_FALSE(json.contains("u_min") || json.contains("i_load"));
  EXPECT_EQ(json["code"], 0);
}

TEST(MapText, HasALineForEveryRowAndMarksWhatIsNotValid) {
  const std::string text = resultText(bothMaps());
  for (const char* piece : {"\n-10 ", "\n-30 ", "\n13 ", "3600", "]*"})
    EXPECT_TRUE(holds(text, piece)) << text;
}

TEST(StopTimeText, SaysWhatWasAskedAndFound) {
  StopTimeQuery query;
  query.u_required = 7.2;
  const std::string text =
      resultText(query, answered(StopTimeOutcome::kFinite, {30.0, 20.0, kEver}));
  EXPECT_TRUE(holds(text, "7.20 V") &&
              holds(text, "30.0 s, 90 % between 20.0 s and no end: finite"))
      << text;
  const std::string least =
      resultText(query, answered(StopTimeOutcome::kAtLeast, {72.0, 60.0, 7200.0}));
  EXPECT_TRUE(holds(
      least, "at least 72.0 s, the longest that is valid; lower end of the 90 % interval 60.0 s"))
      << least;
}

}  // namespace
}  // namespace battery_sof
