#include <gtest/gtest.h>

#include <cmath>

#include "battery_sof/ros/message_conversion.hpp"

namespace battery_sof {
namespace {

TEST(MessageOf, StatusBeforeTheFirstIdentificationKnowsOfNoSourceAndTheModelAnswers) {
  const SofStatus message = messageOf(StatusContents());
  EXPECT_FALSE(message.source_seen);
  EXPECT_TRUE(std::isnan(message.source_share));
  EXPECT_FALSE(message.voltage_drives);
  EXPECT_TRUE(std::isnan(message.past_cranks.naive_mean_abs_error) && std::isnan(message.past_charges.naive_mean_abs_error));
  EXPECT_TRUE(std::isnan(message.past_cranks.answered_mean_abs_error) && std::isnan(message.past_charges.answered_mean_abs_error));
  EXPECT_EQ(message.past_cranks.answered_by, "model");
  EXPECT_EQ(message.past_charges.answered_by, "model");
}

TEST(MessageOf, StatusSaysWhoImposesWhatAndWhoAnswers) {
  StatusContents contents;
  contents.session.source_seen = contents.session.voltage_drives = true;
  contents.session.source_share = 0.75;
  contents.session.charge_contest.naive_answers = true;
  CrankComparison crank{40.0, -200.0, 10.0, {9.0, 8.7, 9.3}};
  crank.naive_minimum = Interval{9.75, 9.5, 10.0};
  ChargeComparison first{60.0, 10.0, 14.1, 14.1, 30.0, {28.0, 25.0, 31.0}}, second = first;
  first.naive_current = second.naive_current = Interval{29.0, 28.0, 30.0};
  second.naive_answered = true;
  contents.events.add({{crank}, {first, second}});
  const SofStatus message = messageOf(contents);
  EXPECT_TRUE(message.source_seen && message.voltage_drives);
  EXPECT_EQ(message.source_share, 0.75);
  EXPECT_EQ(message.past_cranks.answered_by, "model");
  EXPECT_EQ(message.past_charges.answered_by, "naive");
  EXPECT_EQ(message.past_cranks.mean_abs_error, 1.0);
  EXPECT_EQ(message.past_cranks.naive_mean_abs_error, 0.25);
  EXPECT_EQ(message.past_cranks.answered_mean_abs_error, 1.0);
  EXPECT_EQ(message.past_charges.mean_abs_error, 2.0);
  EXPECT_EQ(message.past_charges.naive_mean_abs_error, 1.0);
  EXPECT_EQ(message.past_charges.answered_mean_abs_error, 1.5);
}

TEST(MessageOf, StatusHasWhatIsExpectedOfTheQuantityThatIsNotImposed) {
  StatusContents contents;
  EXPECT_TRUE(std::isnan(messageOf(contents).expected_time) && std::isnan(messageOf(contents).expected_voltage));
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
