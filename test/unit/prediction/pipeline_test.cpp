#include "prediction/pipeline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/known_model.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

constexpr double kNinety = 1.6449;

/// Events with a standard deviation of 1, believed to be `claimed`.
IntervalCalibration estimated(double claimed, int events, std::uint64_t seed) {
  test::Random random(seed);
  IntervalCalibration scale;
  for (int n = 0; n < events; ++n) {
    const double half = kNinety * claimed * scale.factor;
    update(scale, random.normal(), {0.0, -half, half});
  }
  return scale;
}

TEST(IntervalCalibration, NineOfTenEventsComeToLieInsideHoweverWrongTheWidthsWere) {
  for (const double claimed : {0.2, 0.5, 1.0, 2.0, 5.0}) {
    const IntervalCalibration scale = estimated(claimed, 1000, 7);
    EXPECT_EQ(scale.events, 1000);
    // |ln(last / first)| / (eta n) bounds how far the share may be off.
    const double bound = std::abs(std::log(scale.factor)) / (0.25 * 1000) + 1e-9;
    EXPECT_NEAR(scale.inside / 1000.0, 0.9, bound) << claimed;
    EXPECT_NEAR(scale.inside / 1000.0, 0.9, 0.01) << claimed;
    EXPECT_NEAR(std::log(scale.factor * claimed), 0.0, 0.7) << claimed;
  }
}

TEST(IntervalCalibration, AnEventOutsideWidensAndOneInsideNarrows) {
  IntervalCalibration scale;
  update(scale, 5.0, {0.0, -1.0, 1.0});
  EXPECT_NEAR(scale.factor, std::exp(0.225), 1e-12);
  EXPECT_EQ(scale.inside, 0);
  update(scale, 0.5, {0.0, -1.0, 1.0});
  EXPECT_NEAR(scale.factor, std::exp(0.2), 1e-12);
  EXPECT_EQ(scale.inside, 1);
}

TEST(IntervalCalibration, StaysWithinItsBounds) {
  IntervalCalibration wide, narrow;
  for (int n = 0; n < 2000; ++n) {
    update(wide, 5.0, {0.0, -1.0, 1.0});
    update(narrow, 0.0, {0.0, -1.0, 1.0});
  }
  EXPECT_EQ(wide.factor, 50.0);
  EXPECT_EQ(narrow.factor, 0.1);
}

/// Charges of 10 A at 14 V that the model expected to be of 8 A.
FittedModel chargedBefore() {
  FittedModel model = test::knownModel();
  for (int k = 0; k < 6; ++k)
    model.intervals.event_history.add(
        {PastEvent::Kind::kCharge, 100.0 * k, 10.0, 0.0, 14.0, 14.0, 10.0, 8.0});
  return model;
}

TEST(ChargeAnswer, TakesPastChargesInBelowTheSourcesLimitAndIsTheSourcesThere) {
  const FittedModel model = chargedBefore();
  const ChargeBeginning charge{14.0, 14.0, 10.0};
  EXPECT_GT(chargeAnswer(model, charge, {8.0, 7.0, 9.0}, 50.0).value, 8.5);
  EXPECT_EQ(chargeAnswer(model, charge, {8.0, 7.0, 9.0}, 8.5).value, 8.5)
      << "the source gives no more";
  EXPECT_EQ(chargeAnswer(model, charge, {8.0, 7.0, 8.0}, 8.0).value, 8.0);
  EXPECT_EQ(chargeAnswer(model, charge, {8.0, 7.0, 8.0}, 8.0).lower, 7.0);
}

TEST(CrankAnswer, IsLowerAndWiderWhereTheOpenCircuitVoltageFell) {
  const FittedModel model = test::knownModel();
  const Interval held = crankAnswer(model, -200.0, {{9.0, 8.7, 9.3}, 9.0, 0.0}, {});
  const Interval fallen = crankAnswer(model, -200.0, {{9.0, 8.7, 9.3}, 9.0, 0.0}, {-0.5, 0.01});
  EXPECT_NEAR(held.value, 9.0, 1e-12);
  EXPECT_NEAR(fallen.value, 8.5, 1e-12);
  EXPECT_NEAR(fallen.value - fallen.lower, std::hypot(0.3, kNinety * 0.1), 1e-4);
}

TEST(Answered, RefusesFaultsBeforePhysicsAndNumbersThatAreNotFiniteAfterIt) {
  const FittedModel model = test::knownModel();
  const auto none = [](CrankingAnswer&) -> std::optional<QueryRange> { return std::nullopt; };
  const auto never = [](CrankingAnswer&) -> std::optional<QueryRange> {
    ADD_FAILURE() << "physics of a faulty question";
    return std::nullopt;
  };
  const CrankingAnswer refused = answered<CrankingAnswer>(model, {"a fault"}, 50.0, never);
  EXPECT_EQ(refused.code, AnswerCode::kInvalidQuery);
  EXPECT_EQ(refused.message, "a fault");
  EXPECT_EQ(answered<CrankingAnswer>(model, {}, 50.0, none).code, AnswerCode::kNoModel);
}

TEST(Answered, IsValidUnlessTheQueryGoesBeyondItsWindow) {
  const FittedModel model = test::knownModel();
  const auto drawing = [&](double current) {
    return answered<CrankingAnswer>(model, {}, 50.0, [&](CrankingAnswer& answer) {
      answer.message = "9 V";
      QueryRange range;
      range.min_current = current;
      return std::optional<QueryRange>(range);
    });
  };
  EXPECT_TRUE(drawing(-450.0).valid);
  EXPECT_FALSE(drawing(-550.0).valid);
  EXPECT_EQ(drawing(-550.0).code, AnswerCode::kExtrapolation);
  EXPECT_EQ(drawing(-550.0).message.rfind("not valid: 9 V; outside the identified range: ", 0), 0u);
}

CrankingAnswer drawnFrom(const FittedModel& model, double current = -200.0) {
  return answered<CrankingAnswer>(model, {}, 50.0, [&](CrankingAnswer&) {
    QueryRange range;
    range.min_current = current;
    return std::optional<QueryRange>(range);
  });
}

FittedModel withCranks(FittedModel model, int cranks) {
  for (int k = 0; k < cranks; ++k)
    model.intervals.event_history.add(
        {PastEvent::Kind::kCrank, 100.0 * k, 0.0, -200.0, 0.0, 0.0, 10.0, 10.1});
  return model;
}

TEST(Extrapolation, ACrankNeedsItsResistanceAndOpenCircuitVoltageDeterminedOrThreePastCranks) {
  for (const std::size_t row : {std::size_t{kRowRDischarge}, std::size_t{kRowUDc}}) {
    FittedModel model = test::knownModel();
    model.fit.estimates[row].determined = false;
    EXPECT_TRUE(drawnFrom(test::knownModel()).valid);
    EXPECT_FALSE(drawnFrom(model).valid);
    EXPECT_TRUE(test::holds(drawnFrom(model).message, model.fit.estimates[row].name));
    EXPECT_FALSE(drawnFrom(withCranks(model, 2)).valid);
    EXPECT_TRUE(drawnFrom(withCranks(model, 3)).valid);
  }
}

TEST(Extrapolation, AModelThatMissesItsCranksByMoreThanTheBaselineSupportsNone) {
  FittedModel model = test::knownModel();
  model.fit.scores.cranks = 24;
  model.fit.scores.crank_error_std = 0.476;
  model.fit.baseline.cranks.emplace();
  model.fit.baseline.cranks->events = 24;
  model.fit.baseline.cranks->error = {-0.231 * kNinety, 0.231 * kNinety};
  EXPECT_FALSE(drawnFrom(model).valid);
  EXPECT_TRUE(test::holds(drawnFrom(model).message, "by 476 mV RMS, the baseline by"))
      << drawnFrom(model).message;
  model.fit.scores.crank_error_std = 0.1;
  EXPECT_TRUE(drawnFrom(model).valid);
}

}  // namespace
}  // namespace battery_sof
