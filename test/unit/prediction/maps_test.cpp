#include "prediction/questions.hpp"

#include <gtest/gtest.h>

#include "support/known_model.hpp"

namespace battery_sof {
namespace {

using namespace test;

CrankingQuery crank() {
  CrankingQuery query;
  query.i_cranking = -200.0;
  query.u_required = 7.2;
  return query;
}

TEST(MapCranking, HoldsTheSingleAnswersRowByRow) {
  const FittedModel model = uncertainModel(0.01);
  const std::vector<double> loads = {-10.0, -30.0}, stops = {0.0, 10.0, 60.0};
  const CrankingMap map = mapCranking(model, crank(), loads, stops);
  ASSERT_EQ(map.code, AnswerCode::kOk) << map.message;
  ASSERT_EQ(map.answers.size(), 6u);
  for (std::size_t row = 0; row < loads.size(); ++row)
    for (std::size_t column = 0; column < stops.size(); ++column) {
      CrankingQuery query = crank();
      query.i_load = loads[row];
      query.t_stop = stops[column];
      const CrankingAnswer alone = predictCranking(model, query);
      const CrankingAnswer& of_map = map.answers[row * stops.size() + column];
      EXPECT_EQ(of_map.u_min->value, alone.u_min->value);
      EXPECT_EQ(of_map.u_min->lower, alone.u_min->lower);
      EXPECT_EQ(of_map.message, alone.message);
    }
}

TEST(MapChargeAcceptance, HoldsTheSingleAnswersRowByRow) {
  const FittedModel model = knownModel();
  const ChargeAcceptanceMap map =
      mapChargeAcceptance(model, {0.0, 0.0, 100.0}, {13.0, 14.2}, {1.0, 10.0});
  ASSERT_EQ(map.answers.size(), 4u);
  EXPECT_EQ(map.answers[2].i_boost->value,
            predictChargeAcceptance(model, {14.2, 1.0, 100.0}).i_boost->value);
  EXPECT_EQ(map.answers[1].i_boost->value,
            predictChargeAcceptance(model, {13.0, 10.0, 100.0}).i_boost->value);
}

TEST(Maps, RefuseListsThatAreEmptyOrTooLongAndNameThem) {
  const CrankingMap empty = mapCranking(knownModel(), crank(), {-10.0}, {});
  EXPECT_EQ(empty.code, AnswerCode::kInvalidQuery);
  EXPECT_TRUE(holds(empty.message, "t_stop has 0 values, expected 1 to 200")) << empty.message;
  const std::vector<double> many(kMaxMapSide + 1, 14.0);
  const ChargeAcceptanceMap wide = mapChargeAcceptance(knownModel(), {}, many, {1.0});
  EXPECT_TRUE(holds(wide.message, "u_boost has 201 values")) << wide.message;
  EXPECT_TRUE(wide.answers.empty());
}

TEST(Maps, BrokenOffHaveNoAnswersAndSayHowFarTheyCame) {
  const auto after_half = [](double share) { return share < 0.5 ? "" : "time was up"; };
  const CrankingMap cranks =
      mapCranking(knownModel(), crank(), {-10.0, -20.0}, {1.0, 5.0}, 50.0, after_half);
  EXPECT_EQ(cranks.code, AnswerCode::kInvalidQuery);
  EXPECT_EQ(cranks.message, "stopped after 2 of 4 answers: time was up");
  EXPECT_TRUE(cranks.answers.empty());
  EXPECT_EQ(mapChargeAcceptance(knownModel(), {}, {13.0, 14.0}, {1.0}, 50.0, after_half).message,
            "stopped after 1 of 2 answers: time was up");
}

TEST(Maps, HaveNoAnswersFromAModelThatCannotBeUsed) {
  FittedModel model = knownModel();
  model.fit.status = FitStatus::kNotExcited;
  EXPECT_EQ(mapCranking(model, crank(), {-10.0}, {1.0}).code, AnswerCode::kNoModel);
}

TEST(VerdictOf, IsTheGravestAnswersWithItsSentence) {
  const FittedModel model = knownModel();
  EXPECT_EQ(verdictOf({}, {}).code, AnswerCode::kInvalidQuery);
  const CrankingMap sound = mapCranking(model, crank(), {-10.0}, {1.0, 5.0});
  EXPECT_EQ(verdictOf(sound, {}).code, AnswerCode::kOk);
  EXPECT_EQ(verdictOf(sound, {}).message, "holds: 2 answers");
  CrankingQuery more = crank();
  more.u_required = sound.answers[0].u_min->value;
  const MapVerdict missed = verdictOf(mapCranking(model, more, {-10.0}, {1.0, 5.0}), {});
  EXPECT_EQ(assuranceOf(missed), Assurance::kNotAssured);
  EXPECT_TRUE(holds(missed.message, "not assured: 1 of 2 cranks may miss the limit") ||
              holds(missed.message, "not assured: 2 of 2 cranks may miss the limit"))
      << missed.message;
  more.u_required.reset();
  EXPECT_EQ(verdictOf(mapCranking(model, more, {-10.0}, {1.0}), {}).message, "1 answer");
  const CrankingMap far = mapCranking(model, crank(), {-10.0}, {1.0, 3600.0});
  EXPECT_EQ(verdictOf(far, {}).code, AnswerCode::kExtrapolation);
  EXPECT_EQ(verdictOf(far, {}).message, far.answers[1].message);
  const ChargeAcceptanceMap wrong = mapChargeAcceptance(model, {}, {13.0, -1.0}, {1.0});
  EXPECT_EQ(verdictOf(far, wrong).code, AnswerCode::kInvalidQuery);
  EXPECT_TRUE(holds(verdictOf(far, wrong).message, "u_boost"));
}

}  // namespace
}  // namespace battery_sof
