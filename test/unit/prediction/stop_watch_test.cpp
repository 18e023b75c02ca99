#include "prediction/event_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "prediction/model_monitor.hpp"
#include "support/sourced_drive.hpp"

namespace battery_sof {
namespace {

using namespace test;

constexpr double kLower = 0.3;  // [V], what the model does not know of stops

FittedModel battery() { return uncertainModel(0.01, {"fresh_sulphate"}); }

/// A drive whose voltage in stops is lower than the battery's equations say.
Series lowerInStops(double volts) {
  Series series = sourcedDrive(900, battery(), 10);
  for (std::size_t n = 0; n < series.size(); ++n)
    if (isStopLoad(series.current[n], -15.0)) series.voltage[n] -= volts;
  return series;
}

/// The battery as a model at the first sample of a drive.
FittedModel atFirst(const Series& series) {
  FittedModel model = battery();
  model.fit.source = detectControlMode(series).rule;
  model.fit.source->min_current = -15.0;  // [A]
  model.fit.scores.current_rmse = 0.5;
  model.fit.scores.rmse = 0.15;
  model.state.time = series.time[0];
  model.state.current = series.current[0];
  return model;
}

/// Follows a drive; look(monitor, sample) behind each.
template <typename Look>
std::vector<EventComparison> stopsOf(ModelMonitor& monitor, const Series& series, Look&& look) {
  std::vector<EventComparison> stops;
  for (std::size_t n = 1; n < series.size(); ++n) {
    const auto events =
        monitor.follow({series.time[n], series.current[n], series.voltage[n]}, 10.0);
    stops.insert(stops.end(), events.stops.begin(), events.stops.end());
    look(n);
  }
  return stops;
}

std::vector<EventComparison> stopsOf(const FittedModel& model, const Series& series) {
  ModelMonitor monitor({});
  monitor.install(model, 10.0);
  return stopsOf(monitor, series, [](std::size_t) {});
}

TEST(StopWatch, ComparesEveryStopOfTenSecondsOnceWithWhatTheModelSaidBeforeIt) {
  const Series series = lowerInStops(0.0);
  const auto stops = stopsOf(atFirst(series), series);
  ASSERT_GT(stops.size(), 8u);
  for (std::size_t k = 1; k < stops.size(); ++k) {  // the first one shows where the state began
    EXPECT_EQ(stops[k].duration, 10.0);
    EXPECT_GT(stops[k].time, stops[k - 1].time + 20.0);
    EXPECT_NEAR(stops[k].measured, stops[k].modelled, 0.08) << "the model is true";
    const Interval& expected = stops[k].expected;
    EXPECT_NEAR(stops[k].measured, expected.value, 0.08);
    EXPECT_LT(expected.lower, expected.value);
    EXPECT_NEAR(expected.value - expected.lower, expected.upper - expected.value, 1e-9);
  }
}

TEST(StopWatch, PastStopsCorrectTheNext) {
  const Series series = lowerInStops(kLower);
  const auto stops = stopsOf(atFirst(series), series);
  ASSERT_GT(stops.size(), 8u);
  double modelled = 0.0, expected = 0.0;  // [V], sums of what both miss
  for (std::size_t k = 4; k < stops.size(); ++k) {
    modelled += std::abs(stops[k].measured - stops[k].modelled);
    expected += std::abs(stops[k].measured - stops[k].expected.value);
  }
  EXPECT_GT(modelled, 0.2 * static_cast<double>(stops.size() - 4));
  EXPECT_LT(expected, 0.5 * modelled);
}

TEST(StopWatch, AStopItselfPutsTheLevelRight) {
  const Series series = lowerInStops(kLower);
  ModelMonitor monitor({});
  monitor.install(atFirst(series), 10.0);
  int inside = 0, looks = 0;
  double load_for = 0.0;
  stopsOf(monitor, series, [&](std::size_t n) {
    const bool is_load = isStopLoad(series.current[n], -15.0);
    load_for = is_load ? load_for + 1.0 : 0.0;
    if (load_for < 8.0 || n + 1 == series.size() || !isStopLoad(series.current[n + 1], -15.0))
      return;
    FittedModel now = monitor.now();
    StateEstimator estimator(now);
    InputSample next;
    next.step = estimator.stepTo(series.time[n + 1], series.current[n + 1], 10.0);
    const double modelled = estimator.predict(next).voltage;
    const double missed = series.voltage[n + 1] - modelled - ResidualFilter(now).forecast(1.0).mean;
    ++looks;
    if (std::abs(missed) < 0.06) ++inside;
  });
  ASSERT_GT(looks, 20);
  EXPECT_GE(inside, 9 * looks / 10);
}

TEST(StopWatch, ACrankDoesNotCarryTheLevelOfStops) {
  const Series series = lowerInStops(kLower);
  FittedModel model = atFirst(series);
  for (const EventComparison& stop : stopsOf(model, series))
    model.intervals.event_history.add(stop);
  ResidualFilter errors(model);
  errors.expectStop();
  ASSERT_LT(errors.forecast(10.0).mean, -0.5 * kLower);
  EXPECT_EQ(errors.forecastThrough(10.0).mean, 0.0);
  EXPECT_EQ(errors.forecastThrough(10.0).variance, errors.forecast(10.0).variance);
}

TEST(StopWatch, AStopAcrossAGapOrOneUnderWayAtTheBeginningIsNotCompared) {
  Series series = lowerInStops(0.0);
  const FittedModel model = atFirst(series);
  const auto all = stopsOf(model, series);
  ASSERT_GT(all.size(), 2u);
  const auto at = static_cast<std::size_t>(all[1].time - series.time[0]) + 4;
  ModelMonitor monitor({});
  FittedModel amid = model;
  amid.state.time = series.time[at];
  amid.state.current = series.current[at];
  monitor.install(amid, 10.0);
  monitor.lookBack(slice(series, {0, at + 1}));
  const auto behind = stopsOf(monitor, slice(series, {at, series.size()}), [](std::size_t) {});
  ASSERT_FALSE(behind.empty());
  EXPECT_GT(behind.front().time, all[1].time);
  for (std::size_t n = at; n < series.size(); ++n) series.time[n] += 60.0;
  const auto torn = stopsOf(model, series);
  ASSERT_EQ(torn.size() + 1, all.size());
  EXPECT_NE(torn[1].time, all[1].time);
}

}  // namespace
}  // namespace battery_sof
