#pragma once

#include <memory>
#include <std_msgs/msg/header.hpp>

// Stand-in for the message of ROS 2, with the fields that the example reads.
namespace sensor_msgs::msg {
struct BatteryState {
  using ConstSharedPtr = std::shared_ptr<const BatteryState>;
  std_msgs::msg::Header header;
  float voltage = 0.0f, temperature = 0.0f, current = 0.0f;
};
}  // namespace sensor_msgs::msg
