#include "state/present_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/known_model.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

FittedModel seenTo(double largest) {
  FittedModel model = test::knownModel();
  model.fit.excited.min_current = -largest;
  model.fit.excited.max_current = 0.0;
  model.fit.scores.rmse = 0.01;
  return model;
}

/// Follows errors of one load, one a second.
template <typename ErrorAt>
PresentErrorFilter followed(const FittedModel& model, int seconds, ErrorAt&& error_at) {
  PresentErrorFilter filter(model);
  for (int n = 0; n < seconds; ++n) {
    InputSample sample;
    sample.step.duration = n == 0 ? 0.0 : 1.0;
    sample.step.current = -10.0;
    filter.follow(sample, error_at(n));
  }
  return filter;
}

TEST(PresentError, IsTheMeanOfTheLastSecondsAndFollowsANewLoadAtOnce) {
  PresentErrorFilter filter =
      followed(seenTo(200.0), 60, [](int n) { return n < 30 ? 0.0 : -0.5; });
  EXPECT_NEAR(filter.state().level, -0.5, 0.02);
  InputSample crank;
  crank.step.duration = 1.0;
  crank.step.current = -200.0;
  filter.follow(crank, 0.3);
  EXPECT_NEAR(filter.state().level, 0.3, 0.05);
  EXPECT_EQ(filter.state().current, -200.0);
}

TEST(PresentError, TheSampleOfAnEdgeSaysNothingOnceTheNextIsThere) {
  const auto edge = [](int n) { return n == 0 ? 1.7 : 0.01; };
  const PresentError error = followed(seenTo(200.0), 3, edge).state();
  EXPECT_NEAR(error.level, 0.01, 1e-9);
  EXPECT_LT(std::sqrt(missedAhead(error, 0.0)), 0.011);
  EXPECT_LT(std::sqrt(missedAhead(followed(seenTo(200.0), 60, edge).state(), 30.0)), 0.011);
}

TEST(PresentError, SaysNothingWhereTheVoltageIsControlled) {
  PresentErrorFilter filter = followed(seenTo(200.0), 60, [](int) { return -0.5; });
  InputSample charge;
  charge.step.duration = 1.0;
  charge.step.current = 30.0;
  charge.voltage_controlled = true;
  filter.follow(charge, 1.0);
  EXPECT_FALSE(filter.state().current);
  FittedModel model = seenTo(200.0);
  model.state.residual_state.present = filter.state();
  EXPECT_EQ(forecastOf(model, 30.0, 0.0).share, 0.0);
}

TEST(PresentError, IsAllOfTheSameLoadsErrorAndNothingOfOneThatIsAsFarApartAsCanBe) {
  FittedModel model = seenTo(200.0);
  model.state.residual_state.present = followed(model, 60, [](int) { return -0.5; }).state();
  EXPECT_EQ(forecastOf(model, -10.0, 0.0).share, 1.0);
  EXPECT_NEAR(forecastOf(model, -110.0, 0.0).share, 0.5, 1e-12);
  EXPECT_EQ(forecastOf(model, 190.0, 0.0).share, 0.0);
}

TEST(PresentError, ErrorsThatDriftAreMissedAsFarAsTheyDrifted) {
  constexpr double kDrift = -5e-4;  // [V/s]
  const PresentError error =
      followed(seenTo(200.0), 1200, [](int n) { return kDrift * n; }).state();
  for (const double ahead : {30.0, 120.0, 600.0}) {
    const double behind = 8.0;  // [s], of the level's mean
    EXPECT_NEAR(std::sqrt(missedAhead(error, ahead)), std::abs(kDrift) * (ahead + behind),
                0.2 * std::abs(kDrift) * (ahead + behind))
        << ahead;
  }
}

TEST(PresentError, WhiteErrorsAreMissedByNoMoreFurtherAhead) {
  test::Random random(3);
  const PresentError error =
      followed(seenTo(200.0), 1200, [&](int) { return 0.01 * random.normal(); }).state();
  EXPECT_NEAR(std::sqrt(missedAhead(error, 0.0)), 0.01, 0.003);
  EXPECT_NEAR(std::sqrt(missedAhead(error, 120.0)), 0.01, 0.004);
}

TEST(PresentError, GoesOnFromWhatWasSaved) {
  FittedModel model = seenTo(200.0);
  const auto drifts = [](int n) { return -5e-4 * n; };
  model.state.residual_state.present = followed(model, 600, drifts).state();
  const double before = missedAhead(model.state.residual_state.present, 120.0);
  const PresentError after = followed(model, 30, [&](int n) { return drifts(600 + n); }).state();
  EXPECT_NEAR(missedAhead(after, 120.0), before, 0.1 * before);
}

}  // namespace
}  // namespace battery_sof
