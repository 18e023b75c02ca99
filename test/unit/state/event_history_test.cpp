#include "state/fitted_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace battery_sof {
namespace {

EventHistory missedBy(const std::vector<double>& errors) {
  EventHistory history;
  for (const double error : errors)
    history.add({PastEvent::Kind::kStop, 100.0 * static_cast<double>(history.stops.size()), 10.0,
                 -20.0, 0.0, 0.0, 12.4, 12.4 - error});
  return history;
}

TEST(NextStop, IsTheModelsUsualErrorBeforeTheFirst) {
  const ErrorForecast level = EventHistory().nextStop(0.15);
  EXPECT_EQ(level.mean, 0.0);
  EXPECT_DOUBLE_EQ(level.variance, 0.15 * 0.15);
}

TEST(NextStop, ComesToALevelThatAllStopsShow) {
  const ErrorForecast one = missedBy({-0.3}).nextStop(0.15);
  EXPECT_LT(one.mean, -0.15);
  EXPECT_GT(one.mean, -0.3);
  const ErrorForecast many = missedBy(std::vector<double>(20, -0.3)).nextStop(0.15);
  EXPECT_NEAR(many.mean, -0.3, 0.005);
  EXPECT_LT(many.variance, one.variance);
  EXPECT_GT(std::sqrt(many.variance), 0.02) << "one stop differs from the next";
}

TEST(NextStop, FollowsALevelThatMoves) {
  std::vector<double> errors(20, 0.2);
  errors.insert(errors.end(), 5, -0.2);
  EXPECT_LT(missedBy(errors).nextStop(0.15).mean, -0.1);
}

TEST(NextStop, IsAsUncertainAsPastStopsDiffer) {
  std::vector<double> quiet, loud;
  for (int k = 0; k < 30; ++k) {
    quiet.push_back(k % 2 == 0 ? 0.02 : -0.02);
    loud.push_back(k % 2 == 0 ? 0.2 : -0.2);
  }
  EXPECT_LT(std::sqrt(missedBy(quiet).nextStop(0.1).variance), 0.04);
  EXPECT_GT(std::sqrt(missedBy(loud).nextStop(0.1).variance), 0.18);
}

TEST(NextStop, OfAModelThatIsAlwaysRightIsNotMovedByOneOutlier) {
  EXPECT_LT(std::abs(missedBy({0.3}).nextStop(0.02).mean), 0.03);
}

TEST(EventHistory, KeepsTheNewestStopsAndMovesThemWithTheClock) {
  EventHistory history = missedBy(std::vector<double>(50, 0.1));
  ASSERT_EQ(history.stops.size(), EventHistory::kMost);
  EXPECT_EQ(history.stops.front().time, 1000.0);
  history.moveBy(-500.0);
  EXPECT_EQ(history.stops.front().time, 500.0);
}

}  // namespace
}  // namespace battery_sof
