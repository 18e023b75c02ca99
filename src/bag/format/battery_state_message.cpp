#include "bag/format/battery_state_message.hpp"

#include <cstring>
#include <limits>
#include <stdexcept>

namespace battery_sof {

namespace {

/// Takes values off the front of a message, never more than there is.
class MessageReader {
 public:
  explicit MessageReader(std::string_view bytes) : rest_(bytes), size_(bytes.size()) {}

  template <typename Value>
  Value next() {
    Value value{};
    std::memcpy(&value, skip(sizeof value), sizeof value);
    return value;
  }
  const char* skip(std::uint64_t count) {
    require(count <= rest_.size());
    const char* const begin = rest_.data();
    rest_.remove_prefix(count);
    return begin;
  }
  /// A list of elements of so many bytes, or a text.
  void skipList(std::uint64_t element) { skip(element * next<std::uint32_t>()); }
  void requireEnd() const { require(rest_.empty()); }

 private:
  void require(bool fits) const {
    if (!fits)
      throw std::invalid_argument("a BatteryState of " + std::to_string(size_) +
                                  " bytes has lengths in it that do not fit");
  }

  std::string_view rest_;
  std::size_t size_;
};

template <typename Value>
void append(std::string& bytes, Value value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

BatteryStateMessage BatteryStateMessage::deserialized(std::string_view bytes) {
  MessageReader reader(bytes);
  BatteryStateMessage message;
  reader.skip(sizeof(std::uint32_t));  // seq
  message.stamp.sec = reader.next<std::uint32_t>();
  message.stamp.nsec = reader.next<std::uint32_t>();
  reader.skipList(1);  // frame_id
  message.voltage = reader.next<float>();
  message.temperature = reader.next<float>();
  message.current = reader.next<float>();
  // charge, capacity, design_capacity, percentage; status, health, technology, present
  reader.skip(4 * sizeof(float) + 4);
  reader.skipList(sizeof(float));  // cell_voltage
  reader.skipList(sizeof(float));  // cell_temperature
  reader.skipList(1);              // location
  reader.skipList(1);              // serial_number
  reader.requireEnd();
  return message;
}

std::string BatteryStateMessage::serialized() const {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  constexpr std::uint32_t kNone = 0;
  std::string bytes;
  for (const std::uint32_t value : {kNone, stamp.sec, stamp.nsec, kNone}) append(bytes, value);
  for (const float value : {voltage, temperature, current, kUnknown, kUnknown, kUnknown, kUnknown})
    append(bytes, value);
  for (const std::uint8_t value : {0, 0, 0, 1}) append(bytes, value);
  for (int lists = 0; lists < 4; ++lists) append(bytes, kNone);
  return bytes;
}

const char* BatteryStateMessage::definition() {
  return R"(uint8 POWER_SUPPLY_STATUS_UNKNOWN = 0
uint8 POWER_SUPPLY_STATUS_CHARGING = 1
uint8 POWER_SUPPLY_STATUS_DISCHARGING = 2
uint8 POWER_SUPPLY_STATUS_NOT_CHARGING = 3
uint8 POWER_SUPPLY_STATUS_FULL = 4
uint8 POWER_SUPPLY_HEALTH_UNKNOWN = 0
uint8 POWER_SUPPLY_HEALTH_GOOD = 1
uint8 POWER_SUPPLY_HEALTH_OVERHEAT = 2
uint8 POWER_SUPPLY_HEALTH_DEAD = 3
uint8 POWER_SUPPLY_HEALTH_OVERVOLTAGE = 4
uint8 POWER_SUPPLY_HEALTH_UNSPEC_FAILURE = 5
uint8 POWER_SUPPLY_HEALTH_COLD = 6
uint8 POWER_SUPPLY_HEALTH_WATCHDOG_TIMER_EXPIRE = 7
uint8 POWER_SUPPLY_HEALTH_SAFETY_TIMER_EXPIRE = 8
uint8 POWER_SUPPLY_TECHNOLOGY_UNKNOWN = 0
uint8 POWER_SUPPLY_TECHNOLOGY_NIMH = 1
uint8 POWER_SUPPLY_TECHNOLOGY_LION = 2
uint8 POWER_SUPPLY_TECHNOLOGY_LIPO = 3
uint8 POWER_SUPPLY_TECHNOLOGY_LIFE = 4
uint8 POWER_SUPPLY_TECHNOLOGY_NICD = 5
uint8 POWER_SUPPLY_TECHNOLOGY_LIMN = 6
Header header
float32 voltage
float32 temperature
float32 current
float32 charge
float32 capacity
float32 design_capacity
float32 percentage
uint8 power_supply_status
uint8 power_supply_health
uint8 power_supply_technology
bool present
float32[] cell_voltage
float32[] cell_temperature
string location
string serial_number
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
)";
}

}  // namespace battery_sof
