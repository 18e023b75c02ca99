#include "bag/battery_state_sample.hpp"

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
constexpr std::uint64_t kNanosecondsPerSecondExactly = 1000000000;
// [ns], the last that a stamp holds, and the double nearest to it [s]
constexpr std::uint64_t kLastStamp = (1ULL << 32) * kNanosecondsPerSecondExactly - 1;
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

RawSample rawSampleOf(const BatteryStateMessage& message) {
  RawSample sample;
  sample.time =
      message.stamp.nsec < kNanosecondsPerSecondExactly ? secondsOf(message.stamp) : kNoTime;
  sample.current = shortestDecimal(message.current);
  sample.voltage = shortestDecimal(message.voltage);
  if (!std::isnan(message.temperature))
    sample.temperature = shortestDecimal(message.temperature) + kZeroCelsius;
  return sample;
}

BatteryStateMessage batteryStateOf(const RawSample& sample) {
  BatteryStateMessage message;
  message.stamp = stampOf(sample.time);
  message.current = static_cast<float>(sample.current);
  message.voltage = static_cast<float>(sample.voltage);
  message.temperature =
      sample.temperature ? static_cast<float>(*sample.temperature - kZeroCelsius) : kUnknown;
  return message;
}

Stamp stampOf(double time) {
  const double whole = std::floor(time);
  if (!(time >= 0.0 && time <= kLastTime))
    throw std::invalid_argument("time " + std::to_string(time) +
                                " s is outside what a ROS stamp holds, 0 to 4294967296 s");
  const auto nanoseconds =
      static_cast<std::uint64_t>(std::llround((time - whole) * kNanosecondsPerSecond));
  const std::uint64_t sum = std::min(
      static_cast<std::uint64_t>(whole) * kNanosecondsPerSecondExactly + nanoseconds, kLastStamp);
  return {static_cast<std::uint32_t>(sum / kNanosecondsPerSecondExactly),
          static_cast<std::uint32_t>(sum % kNanosecondsPerSecondExactly)};
}

double secondsOf(const Stamp& stamp) {
  constexpr std::uint64_t kExactInDouble = 1ULL << 53;
  const std::uint64_t nanoseconds = stamp.sec * kNanosecondsPerSecondExactly + stamp.nsec;
  if (nanoseconds < kExactInDouble) return static_cast<double>(nanoseconds) / kNanosecondsPerSecond;
  return stamp.sec + stamp.nsec / kNanosecondsPerSecond;
}

}  // namespace battery_sof
