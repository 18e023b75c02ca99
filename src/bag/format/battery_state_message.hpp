#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace battery_sof {

/// A stamp of ROS.
struct Stamp {
  std::uint32_t sec = 0, nsec = 0;
};

/// What a sensor_msgs/BatteryState measures of a battery.
struct BatteryStateMessage {
  Stamp stamp;               ///< of the header
  float voltage = 0.0f;      ///< [V]
  float temperature = 0.0f;  ///< [degC], NaN: not measured
  float current = 0.0f;      ///< [A], negative when discharging

  static constexpr char kType[] = "sensor_msgs/BatteryState";
  static constexpr char kMd5[] = "4ddae7f048e32fda22cac764685e3974";
  /// Its fields and constants as a bag tells them to a reader that does not know the message: what
  /// kMd5 is the sum of.
  static const char* definition();

  /// @throws std::invalid_argument when the lengths of its lists and texts do not fit the bytes.
  static BatteryStateMessage deserialized(std::string_view bytes);
  /// Every other field is not measured; the battery is present.
  std::string serialized() const;
};

}  // namespace battery_sof
