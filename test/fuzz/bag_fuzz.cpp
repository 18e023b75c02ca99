#include <rosbag/bag.h>

#include "bag/bag_storage.hpp"
#include "fuzzed.hpp"

/// A bag is refused with a sentence that names it, or read; what was read is in order.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace battery_sof;
  static fuzz::MemoryFile file;
  // of the plugin that every bag loads, and unloads when it was the last
  static const rosbag::Bag keeper;
  file.fill(data, size);
  try {
    requireSoundBag(file.path());  // beforehand: making a rosbag::Bag takes longer
    const Series series = readBag(file.path()).series;
    fuzz::require(!series.empty(), "a recording has samples");
    for (std::size_t n = 1; n < series.size(); ++n)
      fuzz::require(series.time[n] > series.time[n - 1], "time increases");
  } catch (const RecordingError& error) {
    fuzz::require(std::string(error.what()).find(file.path().string()) == 0,
                  "an error begins with the file");
  }
  return 0;
}
