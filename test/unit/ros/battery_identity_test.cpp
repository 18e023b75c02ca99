#include "ros/battery_identity.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace battery_sof {
namespace {

using Sample = BatteryIdentity::Sample;

sensor_msgs::BatteryState messageOf(const std::string& serial_number, bool is_present = true) {
  sensor_msgs::BatteryState message;
  message.serial_number = serial_number;
  message.present = is_present;
  return message;
}

TEST(BatteryIdentity, AnotherSerialNumberInARowIsAnotherBattery) {
  BatteryIdentity identity;
  EXPECT_EQ(identity.observe(messageOf("A1")), Sample::kOfBattery);
  for (int k = 1; k < BatteryIdentity::kConvinced; ++k) {
    EXPECT_EQ(identity.observe(messageOf("B2")), Sample::kOfNone) << k;
    EXPECT_EQ(identity.whyNone(),
              "samples with serial number B2 are ignored, because the battery's is A1");
  }
  EXPECT_EQ(identity.observe(messageOf("B2")), Sample::kOfOther);
  EXPECT_EQ(identity.serialNumber(), "B2");
  EXPECT_EQ(identity.observe(messageOf("B2")), Sample::kOfBattery);
  EXPECT_EQ(identity.observe(messageOf("")), Sample::kOfBattery) << "a message without one";
}

TEST(BatteryIdentity, TwoBatteriesOnOneTopicDoNotTakeTurns) {
  BatteryIdentity identity;
  for (int k = 0; k < 100; ++k) {
    EXPECT_EQ(identity.observe(messageOf("A1")), Sample::kOfBattery);
    EXPECT_EQ(identity.observe(messageOf("B2")), Sample::kOfNone);
  }
}

TEST(BatteryIdentity, ASavedModelsSerialNumberIsTheOneToCompareWith) {
  BatteryIdentity identity;
  identity.expect("A1");
  Sample sample = Sample::kOfBattery;
  for (int k = 0; k < BatteryIdentity::kConvinced; ++k) sample = identity.observe(messageOf("B2"));
  EXPECT_EQ(sample, Sample::kOfOther);
}

TEST(BatteryIdentity, AbsenceCountsOnceADriverSaidPresent) {
  BatteryIdentity never;
  EXPECT_EQ(never.observe(messageOf("", false)), Sample::kOfBattery) << "not filled in";
  BatteryIdentity identity;
  EXPECT_EQ(identity.observe(messageOf("", true)), Sample::kOfBattery);
  EXPECT_EQ(identity.observe(messageOf("", false)), Sample::kOfNone);
  EXPECT_EQ(identity.whyNone(),
            "the battery is reported as not present, so its samples are ignored");
  EXPECT_EQ(identity.observe(messageOf("", true)), Sample::kOfBattery);
  EXPECT_EQ(identity.whyNone(), "");
}

TEST(BatteryIdentity, TakesADesignCapacityThatABatteryCanHave) {
  BatteryIdentity identity;
  sensor_msgs::BatteryState message = messageOf("A1");
  for (const float none : {0.0F, -70.0F, 1e6F, std::numeric_limits<float>::quiet_NaN()}) {
    message.design_capacity = none;
    identity.observe(message);
    EXPECT_FALSE(identity.designCapacity()) << none;
  }
  message.design_capacity = 70.0F;
  message.location = "left\nslot";
  identity.observe(message);
  EXPECT_EQ(identity.designCapacity(), 70.0);
  EXPECT_EQ(identity.location().find('\n'), std::string::npos);
}

}  // namespace
}  // namespace battery_sof
