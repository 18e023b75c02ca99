#include "prediction/baseline_selector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "prediction/model_snapshot.hpp"
#include "support/known_model.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Ten seconds of 10 A at 14 V.
EventComparison chargeAt(double time, double expected, const Interval& baseline) {
  EventComparison charge;
  charge.kind = PastEvent::Kind::kCharge;
  charge.time = time;
  charge.duration = charge.measured = 10.0;
  charge.voltage = 14.0;
  charge.expected.value = expected;
  charge.baseline = baseline;
  return charge;
}

/// Charges of 10 A, expected by a model and by a baseline predictor that err by as much as they are
/// reported.
class Charges {
 public:
  void pass(double model_error, double baseline_error) {
    time_ += 60.0;
    const bool baseline_answered = selector.isBaselineSelected();
    model_ += std::abs(model_error);
    baseline_ += std::abs(baseline_error);
    answered_ += std::abs(baseline_answered ? baseline_error : model_error);
    const double value = 10.0 - baseline_error;
    last = selector.add(chargeAt(time_, 10.0 - model_error, {value, value - 1.0, value + 1.0}));
    if (last.lower <= 10.0 && 10.0 <= last.upper) ++inside;
    ++events;
  }
  /// An event with normal errors, drawn one after the other: a compiler evaluates arguments in an
  /// order of its own.
  void draw(test::Random& random, double model_std) {
    const double baseline_error = random.normal();
    pass(model_std * random.normal(), baseline_error);
  }
  double ofBaseline() const { return answered_ / baseline_; }
  double ofModel() const { return answered_ / model_; }

  BaselineSelector selector;
  Interval last;
  int inside = 0, events = 0;

 private:
  double time_ = 0.0, model_ = 0.0, baseline_ = 0.0, answered_ = 0.0;
};

TEST(BaselineSelector, TheModelAnswersUntilFiveEventsWereCompared) {
  Charges charges;
  for (int k = 0; k < 4; ++k) charges.pass(3.0, 1.0);
  EXPECT_FALSE(charges.selector.isBaselineSelected());
  charges.pass(3.0, 1.0);
  EXPECT_TRUE(charges.selector.isBaselineSelected());
  EXPECT_EQ(charges.selector.score().events, 5);
  EXPECT_NEAR(charges.selector.score().model_error, 3.0, 1e-12);
  EXPECT_NEAR(charges.selector.score().baseline_error, 1.0, 1e-12);
}

TEST(BaselineSelector, OverABadModelsDriveAnswersAreAtMostFivePercentWorseThanNaiveOnes) {
  test::Random random(3);
  for (const double bad : {1.06, 1.5, 4.0}) {
    Charges charges;
    for (int k = 0; k < 400; ++k) charges.draw(random, bad);
    EXPECT_LT(charges.ofBaseline(), 1.05) << bad;
  }
}

TEST(BaselineSelector, AModelThatGoesBadAndComesBackIsFollowed) {
  test::Random random(4);
  Charges charges;
  for (int k = 0; k < 600; ++k) {
    const bool bad = k / 100 % 2 == 1;
    charges.draw(random, bad ? 4.0 : 0.3);
  }
  EXPECT_LT(charges.ofBaseline(), 1.05);
  EXPECT_LT(charges.ofModel(), 0.6);
}

TEST(BaselineSelector, ABetterModelAnswersThroughout) {
  test::Random random(5);
  Charges charges;
  for (int k = 0; k < 200; ++k) {
    charges.draw(random, 0.5);
    EXPECT_FALSE(charges.selector.isBaselineSelected()) << k;
  }
}

TEST(BaselineSelector,
     OneThatIsHardlyBetterDoesNotTakeOverAndOneThatAnswersGivesWayToTheSmallerError) {
  Charges charges;
  for (int k = 0; k < 30; ++k) charges.pass(1.04, 1.0);
  EXPECT_FALSE(charges.selector.isBaselineSelected());
  for (int k = 0; k < 30; ++k) charges.pass(1.06, 1.0);
  EXPECT_TRUE(charges.selector.isBaselineSelected());
  for (int k = 0; k < 30; ++k) charges.pass(1.01, 1.0);
  EXPECT_TRUE(charges.selector.isBaselineSelected());
  for (int k = 0; k < 30; ++k) charges.pass(0.99, 1.0);
  EXPECT_FALSE(charges.selector.isBaselineSelected());
}

TEST(BaselineSelector, RemembersTwentyEventsAndAQuarterOfAnHour) {
  BaselineSelector often, seldom;
  for (int k = 0; k < 100; ++k) {
    const EventComparison event = chargeAt(20.0 * k, 9.0, {9.0, 8.0, 10.0});
    often.add(event);
    EventComparison rare = event;
    rare.time *= 10.0;
    seldom.add(rare);
  }
  EXPECT_EQ(often.score().events, 46);
  EXPECT_EQ(seldom.score().events, 20);
}

TEST(BaselineSelector, ItsIntervalsAreScaledUntilNineInTenEventsFallInside) {
  test::Random random(6);
  Charges charges;
  for (int k = 0; k < 500; ++k) charges.pass(9.0, 4.0 * random.normal());
  EXPECT_NEAR(charges.inside / static_cast<double>(charges.events), 0.9, 0.03);
  EXPECT_GT(charges.selector.selection().scale.factor, 4.0);
}

TEST(BaselineSelector, AJumpOfTheClockKeepsWhatWasCompared) {
  Charges charges;
  for (int k = 0; k < 6; ++k) charges.pass(3.0, 1.0);
  charges.selector.moveBy(-1e6);
  EXPECT_TRUE(charges.selector.isBaselineSelected());
  EXPECT_EQ(charges.selector.score().events, 6);
}

// ----------------------------------------------------------------------------------------------------
// answers

FittedModel modelWithBaseline() {
  FittedModel model = test::knownModel();
  model.fit.baseline.current_from_voltage =
      BaselineLine{-100.0, 8.0, 1.0, -2.0, 2.0, 13.5, 0.5, 100};
  model.fit.baseline.phase = BaselinePhase{1.0, std::vector<double>(20, 12.0), 1.0, -2.0, 2.0, 8};
  model.fit.baseline.cranks =
      BaselineCranks{{-210.0, 9.4}, {-205.0, 9.5}, 11.4, 0.01, -0.1, 0.2, 8};
  return model;
}

BaselineSelection selection(double least, double most, double duration) {
  BaselineSelection baseline;
  baseline.score = {8, 2.0, 1.2, true};
  baseline.scale.factor = 2.0;
  baseline.least = least;
  baseline.most = most;
  baseline.shortest = baseline.longest = duration;
  return baseline;
}

ModelSnapshot liveBaseline() {
  return ModelSnapshot(modelWithBaseline(), std::nullopt, 50.0,
                       {selection(-210.0, -190.0, 0.0), selection(13.8, 14.4, 10.0), {}});
}

TEST(ModelSnapshot, ACrankIsAnsweredByTheLineThroughPastCranksWhereThatWasBetter) {
  CrankingQuery query{-20.0, 5.0, -200.0, 0.5, 9.3};
  const CrankingAnswer answer = liveBaseline().predictCranking(query);
  EXPECT_NEAR(answer.u_min->value, 9.4, 1e-9);
  EXPECT_NEAR(answer.u_min->lower, 9.2, 1e-9);
  EXPECT_NEAR(answer.u_min->upper, 9.8, 1e-9);
  EXPECT_FALSE(*answer.capable);
  EXPECT_TRUE(answer.valid);
  EXPECT_THAT(
      answer.message,
      HasSubstr(
          "9.40 V, 90 % between 9.20 and 9.80 V: may not hold 9.30 V; the baseline (line through "
          "past cranks) answers: it missed 1.200 V where the model missed 2.000 V"));
}

TEST(ModelSnapshot, AChargeIsAnsweredByTheMedianOfPastChargesWhereThatWasBetter) {
  const ChargeAcceptanceAnswer answer =
      liveBaseline().predictChargeAcceptance({14.0, 10.0, 13.0, {}});
  EXPECT_NEAR(answer.i_boost->value, 12.0, 1e-9);
  EXPECT_NEAR(answer.i_boost->lower, 8.0, 1e-9);
  EXPECT_NEAR(answer.i_boost->upper, 13.0, 1e-9) << "the source gives no more";
  EXPECT_THAT(answer.message, HasSubstr("the baseline (median of past charges) answers: it missed "
                                        "1.2 A where the model missed 2.0 A"));
}

TEST(ModelSnapshot, LongChargesHaveAContestOfTheirOwn) {
  const BaselineSelections baseline{{}, {}, selection(13.8, 14.4, 60.0)};
  const ModelSnapshot live(modelWithBaseline(), std::nullopt, 50.0, baseline);
  const ModelSnapshot model(modelWithBaseline(), std::nullopt, 50.0);
  EXPECT_THAT(live.predictChargeAcceptance({14.0, 60.0}).message,
              HasSubstr("the baseline (median of past charges) answers"));
  EXPECT_NEAR(live.predictChargeAcceptance({14.0, 60.0}).i_boost->value, 12.0, 1e-9)
      << "12 A on the line, too";
  EXPECT_EQ(live.predictChargeAcceptance({14.0, 10.0}).message,
            model.predictChargeAcceptance({14.0, 10.0}).message);
}

TEST(ModelSnapshot, QuestionsUnlikeWhatWasComparedAreTheModels) {
  const ModelSnapshot live = liveBaseline();
  const ModelSnapshot model(modelWithBaseline(), std::nullopt, 50.0);
  EXPECT_EQ(live.predictCranking({-20.0, 5.0, -300.0, 0.5}).message,
            model.predictCranking({-20.0, 5.0, -300.0, 0.5}).message);
  EXPECT_EQ(live.predictCranking({-1.0, 3600.0, -200.0, 0.5}).message,
            model.predictCranking({-1.0, 3600.0, -200.0, 0.5}).message);
  for (const ChargeAcceptanceQuery& query :
       {ChargeAcceptanceQuery{13.2, 10.0}, ChargeAcceptanceQuery{14.0, 60.0}})
    EXPECT_EQ(live.predictChargeAcceptance(query).message,
              model.predictChargeAcceptance(query).message);
}

TEST(ModelSnapshot, WithoutNumbersNobodyAnswersInTheModelsPlace) {
  EXPECT_EQ(liveBaseline().predictCranking({5.0, 5.0, -200.0, 0.5}).code,
            AnswerCode::kInvalidQuery);
  EXPECT_FALSE(liveBaseline().predictCranking({5.0, 5.0, -200.0, 0.5}).u_min);
  const ModelSnapshot none({}, "nothing identified yet", 50.0,
                           {selection(-210.0, -190.0, 0.0), {}, {}});
  EXPECT_EQ(none.predictCranking({-20.0, 5.0, -200.0, 0.5}).message, "nothing identified yet");
}

TEST(ModelSnapshot, MapsAreAnsweredAsTheirCells) {
  const ModelSnapshot live = liveBaseline();
  const CrankingMap cranks =
      live.mapCranking({-20.0, 5.0, -200.0, 0.5}, {-10.0, -20.0}, {5.0, 3600.0});
  EXPECT_NEAR(cranks.answers[0].u_min->value, 9.4, 1e-9);
  EXPECT_THAT(cranks.answers[1].message, Not(HasSubstr("answers: it missed")));
  EXPECT_NEAR(cranks.answers[2].u_min->value, 9.4, 1e-9);
  const ChargeAcceptanceMap charges = live.mapChargeAcceptance({}, {13.0, 14.0}, {10.0, 60.0});
  EXPECT_NEAR(charges.answers[2].i_boost->value, 12.0, 1e-9);
  for (const std::size_t k : {0u, 1u, 3u})
    EXPECT_THAT(charges.answers[k].message, Not(HasSubstr("answers: it missed")));
}

TEST(ModelSnapshot, AStopTimeStaysTheModelsAndSaysSo) {
  StopTimeQuery query;
  query.i_load = -20.0;
  query.i_cranking = -200.0;
  query.u_required = 7.2;
  const ModelSnapshot model(modelWithBaseline(), std::nullopt, 50.0);
  EXPECT_EQ(liveBaseline().predictStopTime(query).t_stop->value,
            model.predictStopTime(query).t_stop->value);
  EXPECT_THAT(liveBaseline().predictStopTime(query).message,
              HasSubstr("is better at cranks at present"));
}

}  // namespace
}  // namespace battery_sof
