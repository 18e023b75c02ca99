#include "recording/events.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

Series seriesOf(const std::vector<double>& current, double interval) {
  Series series;
  for (std::size_t k = 0; k < current.size(); ++k) {
    series.append({interval * static_cast<double>(k), current[k], 12.5 + 0.005 * current[k]});
  }
  return series;
}

std::vector<EventKind> kindsOf(const std::vector<Event>& events) {
  std::vector<EventKind> kinds;
  for (const Event& event : events) kinds.push_back(event.kind);
  return kinds;
}

void expectEverySampleInOneEvent(const Series& series, const std::vector<Event>& events) {
  std::size_t next = 0;
  for (const Event& event : events) {
    EXPECT_EQ(event.range.first, next);
    EXPECT_FALSE(event.range.empty());
    next = event.range.last;
  }
  EXPECT_EQ(next, series.size());
}

TEST(Events, SingleSampleAtOneHertzIsACrank) {
  const Series series = seriesOf({-15.0, -14.8, -250.0, -22.0, -15.0, 10.0, 0.0}, 1.0);
  const auto events = detectEvents(series);
  EXPECT_EQ(kindsOf(events),
            (std::vector<EventKind>{EventKind::kDischarge, EventKind::kCrank, EventKind::kDischarge,
                                    EventKind::kCharge, EventKind::kRest}));
  EXPECT_EQ(events[1].range.size(), 1U);
  EXPECT_EQ(events[1].duration(), 0.0);
  EXPECT_DOUBLE_EQ(events[1].peak_current, -250.0);
  EXPECT_DOUBLE_EQ(events[1].min_voltage, 11.25);
}

TEST(Events, CrankAtOneHundredHertzReachesFromHalfTheCrankCurrentToHalfOfIt) {
  std::vector<double> current(100, -20.0);
  for (int k = 0; k < 100; ++k) {
    current.push_back(k < 60 ? -150.0 - 300.0 * std::exp(-k / 6.0) : -100.0);
  }
  current.insert(current.end(), 100, 30.0);
  const Series series = seriesOf(current, 0.01);
  const auto events = detectEvents(series);
  ASSERT_EQ(kindsOf(events),
            (std::vector<EventKind>{EventKind::kDischarge, EventKind::kCrank, EventKind::kCharge}));
  EXPECT_DOUBLE_EQ(events[1].from, 1.0);
  EXPECT_DOUBLE_EQ(events[1].to, 1.99);
  EXPECT_DOUBLE_EQ(events[1].peak_current, -450.0);
  expectEverySampleInOneEvent(series, events);
}

TEST(Events, LongDischargeAtCrankCurrentIsNotACrank) {
  const auto events = detectEvents(seriesOf(std::vector<double>(100, -160.0), 0.1));
  EXPECT_EQ(kindsOf(events), (std::vector<EventKind>{EventKind::kDischarge}));
  EXPECT_NEAR(events[0].charge, -160.0 * 9.9, 1e-9);
}

TEST(Events, LoadBelowTheCrankCurrentIsADischargeHoweverShort) {
  EXPECT_EQ(kindsOf(detectEvents(seriesOf({0.0, -149.0, 0.0}, 1.0))),
            (std::vector<EventKind>{EventKind::kRest, EventKind::kDischarge, EventKind::kRest}));
}

TEST(Events, GapSplitsAnEvent) {
  Series series = seriesOf({-10.0, -10.0, -10.0, -10.0}, 1.0);
  series.time = {0.0, 1.0, 2.0, 50.0};
  const auto events = detectEvents(series);
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].range.last, 3U);
  EXPECT_DOUBLE_EQ(events[0].charge, -20.0);
  EXPECT_DOUBLE_EQ(events[1].from, 50.0);
}

TEST(Events, RestIsBelowTheRestCurrentOnly) {
  EXPECT_EQ(kindsOf(detectEvents(seriesOf({0.49, -0.49, 0.5, -0.5}, 1.0))),
            (std::vector<EventKind>{EventKind::kRest, EventKind::kCharge, EventKind::kDischarge}));
}

TEST(Events, EverySampleOfADriveBelongsToExactlyOneEvent) {
  Series series = test::cleanDrive();
  for (std::size_t k = series.size() / 2; k < series.size(); ++k) series.time[k] += 60.0;
  expectEverySampleInOneEvent(series, detectEvents(series));
}

TEST(Cranks, AloneAreThoseOfAllTheEvents) {
  test::Random random(5);
  for (int round = 0; round < 50; ++round) {
    Series series;
    for (int k = 0; k < 400; ++k) {
      const double current = std::round(random.uniform(-300.0, 40.0) * random.uniform(0.0, 1.0));
      series.append({(series.empty() ? 0.0 : series.time.back()) +
                         (random.uniform(0.0, 1.0) < 0.05 ? 20.0 : 1.0),
                     current, 12.5 + 0.005 * current + 0.1 * random.normal()});
    }
    const IndexRange range{30, 350};
    const Series part = slice(series, range);
    std::vector<Event> expected;
    for (const Event& event : detectEvents(part, EventLimits{-200.0}))
      if (event.kind == EventKind::kCrank) expected.push_back(event);
    const auto cranks = detectCranks(series, range, {-200.0});
    ASSERT_EQ(cranks.size(), expected.size());
    for (std::size_t k = 0; k < cranks.size(); ++k) {
      EXPECT_EQ(cranks[k].range.first, expected[k].range.first + range.first);
      EXPECT_EQ(cranks[k].range.last, expected[k].range.last + range.first);
      EXPECT_EQ(cranks[k].peak_current, expected[k].peak_current);
      EXPECT_EQ(cranks[k].min_voltage, expected[k].min_voltage);
      EXPECT_EQ(cranks[k].charge, expected[k].charge);
    }
  }
}

TEST(Events, AnEmptySeriesHasNone) { EXPECT_TRUE(detectEvents({}).empty()); }

TEST(Events, WrongLimitsAreRefused) {
  for (const double crank : {0.0, 150.0, -std::numeric_limits<double>::infinity(), std::nan("")})
    EXPECT_THROW(detectEvents({}, EventLimits{crank}), std::invalid_argument);
}

TEST(EventSummary, AddsUpCountsDurationsAndCharge) {
  std::vector<double> current(10, 0.0);
  current.insert(current.end(), 20, 36.0);
  current.insert(current.end(), 1, -300.0);
  current.insert(current.end(), 5, 18.0);
  current.insert(current.end(), 5, -18.0);
  const Series series = seriesOf(current, 1.0);
  const EventSummary summary = summarise(series, detectEvents(series));
  EXPECT_EQ(summary.of(EventKind::kCrank).count, 1U);
  EXPECT_DOUBLE_EQ(summary.of(EventKind::kCrank).duration, 1.0);
  EXPECT_EQ(summary.of(EventKind::kCharge).count, 2U);
  EXPECT_DOUBLE_EQ(summary.of(EventKind::kCharge).duration, 25.0);
  EXPECT_DOUBLE_EQ(summary.of(EventKind::kRest).duration, 10.0);
  EXPECT_DOUBLE_EQ(summary.longest_charge, 20.0);
  EXPECT_EQ(summary.long_charges, 1U);
  EXPECT_DOUBLE_EQ(*summary.max_charge_voltage, 12.5 + 0.005 * 36.0);
  EXPECT_DOUBLE_EQ(*summary.min_charge_voltage, 12.5 + 0.005 * 18.0);
  EXPECT_DOUBLE_EQ(summary.charge_in, 18.0 + 19.0 * 36.0 + 4.0 * 18.0);
  EXPECT_DOUBLE_EQ(summary.charge_out, -132.0 - 141.0 - 4.0 * 18.0);
}

TEST(EventSummary, CountsNoChargeAndNoTimeAcrossAGap) {
  Series series = seriesOf({36.0, 36.0, 36.0, 36.0}, 1.0);
  series.time = {0.0, 1.0, 2.0, 3600.0};
  const EventSummary summary = summarise(series, detectEvents(series));
  EXPECT_DOUBLE_EQ(summary.charge_in, 72.0);
  EXPECT_DOUBLE_EQ(summary.of(EventKind::kCharge).duration, 2.0);
}

TEST(EventSummary, WithoutAChargeHasNoChargingVoltage) {
  const Series series = seriesOf({-5.0, -5.0}, 1.0);
  EXPECT_FALSE(summarise(series, detectEvents(series)).max_charge_voltage.has_value());
}

TEST(DescribeEventKind, NamesEveryKind) {
  EXPECT_EQ(toString(EventKind::kCrank), "crank");
  EXPECT_EQ(toString(EventKind::kDischarge), "discharge");
  EXPECT_EQ(toString(EventKind::kCharge), "charge");
  EXPECT_EQ(toString(EventKind::kRest), "rest");
}

TEST(IsStopLoad, IsMoreThanAnIdleNetworkBelowTheRuleAndNoCrank) {
  EXPECT_TRUE(isStopLoad(-20.0, -7.0));
  EXPECT_FALSE(isStopLoad(-5.0, -7.0));
  EXPECT_FALSE(isStopLoad(-1.0, -0.5));
  EXPECT_FALSE(isStopLoad(-120.0, -7.0));
}

/// Samples a second apart.
struct Watched {
  EventDetector detector;
  double time = 0.0;
  void add(double current, std::optional<double> min_current = std::nullopt, double step = 1.0) {
    time += step;
    detector.add(time, current, step > 5.0, min_current);
  }
};

TEST(EventDetector, ACrankEndsWithTheSampleBehindItUnlessItLastsTooLongOrIsTooSmall) {
  Watched watched;
  for (const double current : {-100.0, -160.0, -80.0}) {
    watched.add(current);
    EXPECT_TRUE(watched.detector.isAtCrankLevel());
    EXPECT_FALSE(watched.detector.crankEnded());
  }
  watched.add(-20.0);
  EXPECT_TRUE(watched.detector.crankEnded());
  watched.add(-149.0);
  watched.add(0.0);
  EXPECT_FALSE(watched.detector.crankEnded());
  for (int n = 0; n < 7; ++n) watched.add(-200.0);
  EXPECT_FALSE(watched.detector.mayBeCrank());
  watched.add(0.0);
  EXPECT_FALSE(watched.detector.crankEnded());
}

TEST(EventDetector, AtASourceAChargeBeginsWhereTheVoltageIsControlledBehindADischarge) {
  Watched watched;
  watched.add(5.0, -7.0);
  EXPECT_FALSE(watched.detector.chargeBegins());
  watched.add(-11.0, -7.0);
  watched.add(0.5, -7.0);
  EXPECT_TRUE(watched.detector.chargeBegins());
  watched.detector.denyCharge();
  watched.add(0.6, -7.0);
  EXPECT_TRUE(watched.detector.chargeBegins());
  watched.add(0.7, -7.0);
  EXPECT_FALSE(watched.detector.chargeBegins());
}

TEST(EventDetector, WithoutASourceAChargeBeginsAboveTwoAmperesAndNotAcrossAGap) {
  Watched watched;
  watched.add(1.9);
  EXPECT_FALSE(watched.detector.chargeBegins());
  watched.add(2.1);
  EXPECT_TRUE(watched.detector.chargeBegins());
  watched.add(3.0);
  EXPECT_FALSE(watched.detector.chargeBegins());
  watched.add(3.0, std::nullopt, 60.0);
  EXPECT_FALSE(watched.detector.chargeBegins());
  watched.detector.beginBehind(3.0);
  watched.add(3.0);
  EXPECT_FALSE(watched.detector.chargeBegins());
}

TEST(EventDetector, AStopBeginsBehindASampleThatIsNoneAndNotAcrossAGap) {
  Watched watched;
  watched.add(-20.0, -7.0);
  EXPECT_TRUE(watched.detector.isInStop());
  EXPECT_FALSE(watched.detector.stopBegins()) << "it may have begun before";
  watched.add(10.0, -7.0);
  watched.add(-20.0, -7.0);
  EXPECT_TRUE(watched.detector.stopBegins());
  watched.add(10.0, -7.0);
  watched.add(10.0, -7.0, 60.0);
  watched.add(-20.0, -7.0);
  EXPECT_FALSE(watched.detector.stopBegins());
}

}  // namespace
}  // namespace battery_sof
