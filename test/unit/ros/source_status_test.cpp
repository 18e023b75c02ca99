#include <gtest/gtest.h>

#include <cmath>

#include "ros/message_conversion.hpp"

namespace battery_sof {
namespace {

TEST(MessageOf, StatusBeforeTheFirstIdentificationKnowsOfNoSourceAndOfNoErrors) {
  const SofStatus message = messageOf(StatusContents());
  EXPECT_FALSE(message.charger_present);
  EXPECT_TRUE(std::isnan(message.charger_share));
  EXPECT_FALSE(message.voltage_controlled);
  EXPECT_TRUE(std::isnan(message.past_cranks.baseline_mean_abs_error) &&
              std::isnan(message.past_charges.baseline_mean_abs_error));
}

TEST(MessageOf, StatusSaysWhoImposesWhatAndWhatModelAndBaselineMissed) {
  StatusContents contents;
  contents.session.charger_present = contents.session.voltage_controlled = true;
  contents.session.charger_share = 0.75;
  EventComparison crank{{PastEvent::Kind::kCrank, 40.0, 0.0, -200.0, 0.0, 0.0, 10.0},
                        {9.0, 8.7, 9.3}};
  crank.baseline = Interval{9.75, 9.5, 10.0};
  EventComparison first{{PastEvent::Kind::kCharge, 60.0, 10.0, 0.0, 14.1, 14.1, 30.0},
                        {28.0, 25.0, 31.0}};
  first.baseline = Interval{29.0, 28.0, 30.0};
  contents.events.add({{crank}, {first, first}, {}});
  const SofStatus message = messageOf(contents);
  EXPECT_TRUE(message.charger_present && message.voltage_controlled);
  EXPECT_EQ(message.charger_share, 0.75);
  EXPECT_EQ(message.past_cranks.mean_abs_error, 1.0);
  EXPECT_EQ(message.past_cranks.baseline_mean_abs_error, 0.25);
  EXPECT_EQ(message.past_charges.mean_abs_error, 2.0);
  EXPECT_EQ(message.past_charges.baseline_mean_abs_error, 1.0);
}

TEST(MessageOf, StatusHasWhatIsExpectedOfTheQuantityThatIsNotImposed) {
  StatusContents contents;
  EXPECT_TRUE(std::isnan(messageOf(contents).expected_time) &&
              std::isnan(messageOf(contents).expected_voltage));
  contents.session.expected = ExpectedSample{40.0, 12.25, std::nullopt};
  EXPECT_EQ(messageOf(contents).expected_time, 40.0);
  EXPECT_EQ(messageOf(contents).expected_voltage, 12.25);
  EXPECT_TRUE(std::isnan(messageOf(contents).expected_current));
  contents.session.expected = ExpectedSample{41.0, std::nullopt, -3.5};
  EXPECT_TRUE(std::isnan(messageOf(contents).expected_voltage));
  EXPECT_EQ(messageOf(contents).expected_current, -3.5);
}

}  // namespace
}  // namespace battery_sof
