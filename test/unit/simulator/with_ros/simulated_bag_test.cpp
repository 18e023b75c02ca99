#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/BatteryState.h>

#include <cmath>

#include "simulator/simulate_command.hpp"
#include "support/commands.hpp"

namespace battery_sof_simulator {
namespace {

class SimulatedBag : public battery_sof::test::InFolder {
 protected:
  SimulatedBag() : InFolder("simulated bag") {
    scenario_ =
        write("drive.yaml", "{name: drive, seed: 3, duration_s: 20, profile: {kind: city_drive}}");
  }
  static battery_sof::test::Outcome simulate(const std::vector<std::string>& arguments) {
    return battery_sof::test::outcomeOf([](auto&... all) { return runSimulate(all...); },
                                        arguments);
  }
  std::string scenario_;
};

TEST_F(SimulatedBag, WritesABagOfBatteryStatesStampedWithTheTime) {
  ASSERT_EQ(simulate({scenario_, path("out.bag")}).code, 0);
  rosbag::Bag bag(path("out.bag"), rosbag::bagmode::Read);
  rosbag::View view(bag, rosbag::TopicQuery("/battery_state"));
  ASSERT_EQ(view.size(), 2000u);
  std::uint64_t n = 0;
  for (const auto& instance : view) {
    const auto message = instance.instantiate<sensor_msgs::BatteryState>();
    ASSERT_NE(message, nullptr);
    ASSERT_EQ(message->header.stamp.toNSec(), 10000000ULL * n++);
    ASSERT_GT(message->voltage, 9.0f);
    ASSERT_TRUE(std::isnan(message->temperature) && std::isnan(message->charge));
  }
}

}  // namespace
}  // namespace battery_sof_simulator
