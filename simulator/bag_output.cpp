#include "simulator/recording_output.hpp"

#include <rosbag/bag.h>
#include <sensor_msgs/BatteryState.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace battery_sof_simulator {
namespace {

constexpr char kTopic[] = "/battery_state";
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

sensor_msgs::BatteryState messageOf(const RecordedSample& sample, float temperature) {
  sensor_msgs::BatteryState message;
  message.header.stamp.fromNSec(static_cast<std::uint64_t>(std::llround(sample.time * 1e9)));
  message.current = static_cast<float>(sample.current);
  message.voltage = static_cast<float>(sample.voltage);
  message.temperature = temperature;
  message.charge = message.capacity = message.design_capacity = message.percentage = kUnknown;
  message.present = 1;
  return message;
}

}  // namespace

void writeBag(const std::filesystem::path& path, const std::vector<RecordedSample>& samples,
              const std::vector<double>& temperature) {
  auto bag = std::make_unique<rosbag::Bag>(path.string(), rosbag::bagmode::Write);
  try {
    for (std::size_t n = 0; n < samples.size(); ++n) {
      const auto message = messageOf(
          samples[n], temperature.empty() ? kUnknown : static_cast<float>(temperature[n]));
      bag->write(kTopic, std::max(message.header.stamp, ros::TIME_MIN), message);
    }
    bag->close();
  } catch (...) {
    // its destructor would write once more, throw and so end the program
    static_cast<void>(bag.release());
    throw;
  }
}

}  // namespace battery_sof_simulator
