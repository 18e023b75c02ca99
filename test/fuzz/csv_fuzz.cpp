#include "battery_sof/csv.hpp"
#include "fuzzed.hpp"
#include "recording/checks.hpp"

/// A CSV file is refused with a sentence that names it, or read; what was read is in order, can be
/// looked over.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace battery_sof;
  static fuzz::MemoryFile file;
  file.fill(data, size);
  try {
    const Recording recording = readCsv(file.path());
    const Series& series = recording.series;
    fuzz::require(!series.empty() && series.size() <= recording.offered,
                  "a recording has samples, of those that were offered");
    for (std::size_t n = 1; n < series.size(); ++n)
      fuzz::require(series.time[n] > series.time[n - 1], "time increases");
    checkRecording(recording);
  } catch (const RecordingError& error) {
    fuzz::require(std::string(error.what()).find(file.path().string()) == 0,
                  "an error begins with the file");
  }
  return 0;
}
