#include "diagnosis/profile_interval.hpp"

#include <gtest/gtest.h>

#include "support/composed.hpp"

namespace battery_sof {
namespace {

using namespace test;

struct Fitted {
  InputSequence inputs;
  WhitenedFit fit;
};

Fitted fitted(const std::vector<std::string>& truth, const std::vector<std::string>& effects,
              const WhitenedSearch& search = {}) {
  const Series series = recordingOf(truth, 240.0);
  Fitted fitted{inputSequence(series, whole(series)), {}};
  const BatteryModel model(effects);
  fitted.fit =
      fitWhitened(model, fitted.inputs, {typicalStart(model, fitted.inputs)}, std::nullopt, search);
  return fitted;
}

TEST(ProfileInterval, OfADeterminedStrengthHoldsTheTruthAndIsClosed) {
  const Fitted f = fitted({"current_dependent_resistance"}, {"current_dependent_resistance"});
  const ProfileInterval interval = profileInterval(f.fit, f.inputs, "low_current_resistance", 1e-4);
  ASSERT_TRUE(interval.lower && interval.upper);
  EXPECT_LT(*interval.lower, 0.003);
  EXPECT_GT(*interval.upper, 0.003);
  EXPECT_LT(*interval.upper - *interval.lower, 0.001);
}

TEST(ProfileInterval, DoesNotDependOnTheFirstStep) {
  const Fitted f = fitted({"current_dependent_resistance"}, {"current_dependent_resistance"});
  const ProfileInterval near = profileInterval(f.fit, f.inputs, "low_current_resistance", 2e-5);
  const ProfileInterval far = profileInterval(f.fit, f.inputs, "low_current_resistance", 5e-4);
  ASSERT_TRUE(near.upper && far.upper);
  EXPECT_NEAR(*near.upper, *far.upper,
              0.1 * (*near.upper -
                     f.fit.point.parameters[*f.fit.model.parameterRow("low_current_resistance")]));
}

TEST(ProfileInterval, UnderAFleetsPriorIsNoWiderThanThePrior) {
  const double std = 1e-6;
  WhitenedSearch search;
  search.priors = {
      {{"current_dependent_resistance"}, {{"low_current_resistance", 0.003, std, false}}}};
  const Fitted f =
      fitted({"current_dependent_resistance"}, {"current_dependent_resistance"}, search);
  const ProfileInterval interval = profileInterval(f.fit, f.inputs, "low_current_resistance", 1e-4);
  ASSERT_TRUE(interval.lower && interval.upper);
  EXPECT_LT(*interval.upper - *interval.lower, 2.0 * 2.1 * std);
}

TEST(ProfileInterval, OfAStrengthThatIsNotThereIsOpenBelow) {
  const Fitted f = fitted({}, {"gassing"});
  EXPECT_FALSE(profileInterval(f.fit, f.inputs, "gassing_current", 0.05).lower);
}

TEST(ProfileInterval, RefusesAParameterThatIsNotThere) {
  const Fitted f = fitted({}, {});
  EXPECT_THROW(profileInterval(f.fit, f.inputs, "b3", 0.1), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof
