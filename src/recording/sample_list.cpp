#include "battery_sof/sample_list.hpp"

#include "util/printable.hpp"

namespace battery_sof {

Recording recordingOf(const std::string& name, const std::vector<RawSample>& samples) {
  if (samples.empty()) throw RecordingError(name + ": has no sample, expected at least one");
  Recording recording;
  recording.name = printable(name);
  Intake intake;
  for (const RawSample& sample : samples) append(recording, intake, sample);
  requireUsable(name, recording);
  return recording;
}

void requireUsable(const std::string& name, const Recording& recording) {
  constexpr double kUnsortedShare = 0.1;  // more clock steps back than this are not a clock's
  const RejectedCounts& rejected = recording.rejected;
  if (rejected.clock_step_back > kUnsortedShare * recording.offered) {
    throw RecordingError(name +
                         ": is not sorted by time: " + std::to_string(rejected.clock_step_back) +
                         " of " + std::to_string(recording.offered) + " samples go back in time");
  }
  if (recording.series.empty()) {
    throw RecordingError(name + ": holds no usable sample: of " +
                         std::to_string(recording.offered) + ", " +
                         std::to_string(rejected.missing_value) + " lack a value, " +
                         std::to_string(rejected.not_finite) + " are not finite, " +
                         std::to_string(rejected.out_of_range) + " are out of range");
  }
}

}  // namespace battery_sof
