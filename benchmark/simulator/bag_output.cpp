#include <cmath>
#include <limits>

#include "bag/format/bag_writer.hpp"
#include "simulator/recording_output.hpp"

namespace battery_sof_simulator {
namespace {

constexpr std::uint64_t kSecond = 1000000000;  // [ns]

battery_sof::BatteryStateMessage messageOf(const RecordedSample& sample, float temperature) {
  const auto time = static_cast<std::uint64_t>(std::llround(sample.time * 1e9));
  battery_sof::BatteryStateMessage message;
  message.stamp = {static_cast<std::uint32_t>(time / kSecond),
                   static_cast<std::uint32_t>(time % kSecond)};
  message.current = static_cast<float>(sample.current);
  message.voltage = static_cast<float>(sample.voltage);
  message.temperature = temperature;
  return message;
}

}  // namespace

void writeBag(const std::filesystem::path& path, const std::vector<RecordedSample>& samples,
              const std::vector<double>& temperature) {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  std::vector<battery_sof::BatteryStateMessage> messages;
  for (std::size_t n = 0; n < samples.size(); ++n)
    messages.push_back(
        messageOf(samples[n], temperature.empty() ? kUnknown : static_cast<float>(temperature[n])));
  battery_sof::writeBatteryStates(path, "/battery_state", messages);
}

}  // namespace battery_sof_simulator
