#pragma once

#include <sensor_msgs/BatteryState.h>

#include <optional>
#include <string>

namespace battery_sof {

/**
 * @brief What the messages say of the battery itself: whether it is there, which one it is, and how
 * much it holds by design.
 *
 * - present: counts from the first message on that has it true; a driver that never fills it in
 *   says nothing. While it is false the samples are of no battery.
 * - serial_number: another one, in kConvinced messages one after the other, is another battery;
 *   until then its samples are of an unknown one. So two batteries on one topic do not take turns.
 * - design_capacity: taken from 1 to 1000 Ah; others, 0 and NaN too, say nothing.
 */
class BatteryIdentity {
 public:
  static constexpr int kConvinced = 10;  ///< messages with another serial number

  /// What a message's sample is of.
  enum class Sample {
    kOfBattery,  ///< the battery that was followed so far
    kOfOther,    ///< another one from now on
    kOfNone,     ///< none: not present, or not known yet which
  };

  /// @param serial_number of the battery that a saved model is of; empty when unknown.
  void expect(const std::string& serial_number) { serial_number_ = serial_number; }

  Sample observe(const sensor_msgs::BatteryState& message);

  /// printable(), empty before the first.
  const std::string& serialNumber() const { return serial_number_; }
  const std::string& location() const { return location_; }
  std::optional<double> designCapacity() const { return design_capacity_; }  ///< [Ah]
  /// Why samples are left out at present, one sentence; empty when none are.
  const std::string& whyNone() const { return why_none_; }

 private:
  Sample judge(const sensor_msgs::BatteryState& message);

  bool was_present_ = false;
  std::string serial_number_, location_, other_, why_none_;
  int others_ = 0;  // messages in a row with the serial number other_
  std::optional<double> design_capacity_;
};

}  // namespace battery_sof
