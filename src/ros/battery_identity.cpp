#include "ros/battery_identity.hpp"

#include "util/text.hpp"

namespace battery_sof {
namespace {

// [Ah], as ~capacity_ah
constexpr double kMinCapacity = 1.0, kMaxCapacity = 1000.0;

std::string nameOf(const std::string& text) { return printable(shortened(text)); }

}  // namespace

BatteryIdentity::Sample BatteryIdentity::observe(const sensor_msgs::BatteryState& message) {
  why_none_.clear();
  const Sample sample = judge(message);
  if (sample == Sample::kOfNone) return sample;
  if (sample == Sample::kOfOther) design_capacity_.reset();
  const double capacity = message.design_capacity;
  if (capacity >= kMinCapacity && capacity <= kMaxCapacity) design_capacity_ = capacity;
  if (!message.location.empty()) location_ = nameOf(message.location);
  return sample;
}

BatteryIdentity::Sample BatteryIdentity::judge(const sensor_msgs::BatteryState& message) {
  was_present_ = was_present_ || message.present;
  if (was_present_ && !message.present) {
    why_none_ = "the battery is reported as not present, so its samples are ignored";
    return Sample::kOfNone;
  }
  const std::string serial_number = nameOf(message.serial_number);
  if (serial_number_.empty()) serial_number_ = serial_number;
  if (serial_number.empty() || serial_number == serial_number_) {
    others_ = 0;
    return Sample::kOfBattery;
  }
  others_ = serial_number == other_ ? others_ + 1 : 1;
  other_ = serial_number;
  if (others_ < kConvinced) {
    why_none_ = "samples with serial number " + other_ + " are ignored, because the battery's is " +
                serial_number_;
    return Sample::kOfNone;
  }
  others_ = 0;
  serial_number_ = serial_number;
  return Sample::kOfOther;
}

}  // namespace battery_sof
