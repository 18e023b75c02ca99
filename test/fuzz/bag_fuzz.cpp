#include "bag/bag_storage.hpp"
#include "fuzzed.hpp"

/// A bag is refused with a sentence that names it, or read; what was read is in order.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace battery_sof;
  static fuzz::MemoryFile file;
  file.fill(data, size);
  try {
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
