#include "state/state_estimator.hpp"

#include <gtest/gtest.h>

#include "state/posterior.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

constexpr int kLoads =
    10;  // of 20 As, one a second: all together are as much as a crank, half of them are not

FittedModel sourced() {
  FittedModel model = test::uncertainModel(0.01, {"fresh_sulphate"});
  model.fit.source = ControlModeRule();
  return model;
}

void draw(StateEstimator& estimator, int loads) {
  for (int n = 0; n < loads; ++n) {
    InputSample sample;
    sample.step = estimator.stepTo(estimator.state().time + 1.0, -20.0, 10.0);
    sample.voltage = 12.0;
    estimator.follow(sample);
  }
}

/// [A], where a source takes over.
double currentOfSource(StateEstimator estimator) {
  InputSample sample;
  sample.step = estimator.stepTo(estimator.state().time + 1.0, 20.0, 10.0);
  sample.voltage = 14.0;
  sample.voltage_controlled = true;
  return estimator.predict(sample).current;
}

FittedModel savedHalfWay() {
  FittedModel model = sourced();
  StateEstimator estimator(model);
  draw(estimator, kLoads / 2);
  estimator.saveTo(model);
  return model;
}

double currentAfterTheRest(const FittedModel& model) {
  StateEstimator estimator(model);
  draw(estimator, kLoads - kLoads / 2);
  return currentOfSource(estimator);
}

TEST(StateEstimator, ASnapshotGoesOnAsTheOneItWasTakenOf) {
  StateEstimator estimator(sourced());
  draw(estimator, kLoads / 2);
  StateEstimator snapshot = estimator;
  draw(estimator, kLoads - kLoads / 2);
  const double expected = currentOfSource(estimator);
  draw(snapshot, kLoads - kLoads / 2);
  EXPECT_EQ(currentOfSource(snapshot), expected);
  EXPECT_EQ(snapshot.errors().forecast(1.0).mean, estimator.errors().forecast(1.0).mean);
}

TEST(StateEstimator, ASavedStateKnowsTheDischargeUnderWay) {
  StateEstimator whole(sourced());
  draw(whole, kLoads);
  const double expected = currentOfSource(whole);
  EXPECT_NEAR(currentAfterTheRest(savedHalfWay()), expected, 1e-6);
  FittedModel forgetful = savedHalfWay();
  forgetful.state.missed_crank = {};
  EXPECT_GT(std::abs(currentAfterTheRest(forgetful) - expected), 0.1);
}

TEST(StateEstimator, ParkingEndsTheDischargeUnderWay) {
  const FittedModel model = savedHalfWay();
  FittedModel forgetful = model;
  forgetful.state.missed_crank = {};
  EXPECT_EQ(currentAfterTheRest(parked(model, 3600.0, std::nullopt)),
            currentAfterTheRest(forgetful));
}

}  // namespace
}  // namespace battery_sof
