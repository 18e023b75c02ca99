#include "bag/battery_state_sample.hpp"
#include "fuzzed.hpp"

/// The bytes of a message are refused, or read; what Intake believes of it can be written again at
/// the same time.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace battery_sof;
  const std::string bytes(data, data + size);
  try {
    const RawSample sample = rawSampleOf(BatteryStateMessage::deserialized(bytes));
    if (Intake().judge(sample) != SampleFate::kAccepted) return 0;
    const RawSample again = rawSampleOf(batteryStateOf(sample));
    fuzz::require(again.time == sample.time && again.current == sample.current &&
                      again.voltage == sample.voltage,
                  "a sample stays as it was");
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
