#include "bag/battery_state_message.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>

#include "util/constants.hpp"
#include "util/text.hpp"

namespace battery_sof {

namespace {

constexpr double kNanosecondsPerSecond = 1e9;
// [s], the double nearest to ros::TIME_MAX
constexpr double kLastTime = 4294967296.0;
// [s], the intake counts it as out of range
constexpr double kNoTime = std::numeric_limits<double>::max();
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

double shortestDecimal(float value) {
  if (!std::isfinite(value)) return value;
  const ClassicNumbers classic;
  char text[32];
  for (int digits = 6; digits <= 9; ++digits) {
    std::snprintf(text, sizeof(text), "%.*g", digits, static_cast<double>(value));
    if (std::strtof(text, nullptr) == value) break;
  }
  return std::strtod(text, nullptr);
}

}  // namespace

RawSample rawSampleOf(const sensor_msgs::BatteryState& message) {
  RawSample sample;
  const ros::Time& stamp = message.header.stamp;
  sample.time = stamp.nsec < kNanosecondsPerSecond ? secondsOf(stamp) : kNoTime;
  sample.current = shortestDecimal(message.current);
  sample.voltage = shortestDecimal(message.voltage);
  if (!std::isnan(message.temperature))
    sample.temperature = shortestDecimal(message.temperature) + kZeroCelsius;
  return sample;
}

sensor_msgs::BatteryState batteryStateIn(std::vector<std::uint8_t>& bytes) {
  const auto size = static_cast<std::uint32_t>(bytes.size());
  ros::serialization::IStream walk(bytes.data(), size), stream(bytes.data(), size);
  const auto require = [size](bool fits) {
    if (!fits)
      throw std::invalid_argument("a BatteryState of " + std::to_string(size) +
                                  " bytes has lengths in it that do not fit");
  };
  const auto skip = [&](std::uint64_t count) {
    require(count <= walk.getLength());
    walk.advance(static_cast<std::uint32_t>(count));
  };
  const auto skip_list = [&](std::uint64_t element) {
    std::uint32_t count = 0;
    require(sizeof count <= walk.getLength());
    walk.next(count);
    skip(element * count);
  };
  skip(3 * sizeof(std::uint32_t));  // header: seq, stamp
  skip_list(1);                     // frame_id
  // voltage to percentage; status, health, technology, present
  skip(7 * sizeof(float) + 4);
  skip_list(sizeof(float));  // cell_voltage
  skip_list(sizeof(float));  // cell_temperature
  skip_list(1);              // location
  skip_list(1);              // serial_number
  require(walk.getLength() == 0);
  sensor_msgs::BatteryState message;
  ros::serialization::deserialize(stream, message);
  return message;
}

sensor_msgs::BatteryState batteryStateOf(const RawSample& sample) {
  sensor_msgs::BatteryState message;
  message.header.stamp = rosTime(sample.time);
  message.current = static_cast<float>(sample.current);
  message.voltage = static_cast<float>(sample.voltage);
  message.temperature =
      sample.temperature ? static_cast<float>(*sample.temperature - kZeroCelsius) : kUnknown;
  message.charge = message.capacity = message.design_capacity = message.percentage = kUnknown;
  message.present = true;
  return message;
}

ros::Time rosTime(double time) {
  const double whole = std::floor(time);
  if (!(time >= 0.0 && time <= kLastTime))
    throw std::invalid_argument("time " + std::to_string(time) +
                                " s is outside what a ROS stamp holds, 0 to 4294967296 s");
  const auto nanoseconds = std::llround((time - whole) * kNanosecondsPerSecond);
  ros::Time stamp;
  const std::uint64_t sum =
      static_cast<std::uint64_t>(whole) * 1000000000ULL + static_cast<std::uint64_t>(nanoseconds);
  return stamp.fromNSec(std::min(sum, ros::TIME_MAX.toNSec()));
}

double secondsOf(const ros::Time& stamp) {
  constexpr std::uint64_t kExactInDouble = 1ULL << 53;
  const std::uint64_t nanoseconds = stamp.toNSec();
  if (nanoseconds < kExactInDouble) return static_cast<double>(nanoseconds) / kNanosecondsPerSecond;
  return stamp.sec + stamp.nsec / kNanosecondsPerSecond;
}

}  // namespace battery_sof
