#include "simulator/recording_output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <system_error>

namespace battery_sof_simulator {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& path, const fs::path& beside,
           const std::function<void(const fs::path&)>& fill) {
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  // A file without a name, where the file system has such files.
  const int draft = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
  const auto close = [](const int* open) { static_cast<void>(*open >= 0 && ::close(*open)); };
  const std::unique_ptr<const int, decltype(close)> closed_at_end(&draft, close);
  const fs::path name = draft < 0 ? beside : fs::path("/proc/self/fd/" + std::to_string(draft));
  fill(name);
  const auto link = [&](const fs::path& to) {
    return ::linkat(AT_FDCWD, name.c_str(), AT_FDCWD, to.c_str(), AT_SYMLINK_FOLLOW) == 0;
  };
  if (draft >= 0 && link(path)) return;
  if (draft >= 0 && !link(beside)) throw std::system_error(errno, std::generic_category());
  fs::rename(beside, path);
}

std::string csvOf(const std::vector<RecordedSample>& samples, Digits digits,
                  const std::vector<double>& temperature) {
  std::string text = "time_s,current_a,voltage_v";
  text += temperature.empty() ? "\n" : ",temperature_c\n";
  char cells[120];
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const RecordedSample& sample = samples[n];
    const int more = digits == Digits::kMany ? 3 : 0;
    std::snprintf(cells, sizeof cells, "%.10g,%.*g,%.*g", sample.time, 7 + more, sample.current,
                  8 + more, sample.voltage);
    text += cells;
    if (!temperature.empty()) {
      std::snprintf(cells, sizeof cells, ",%.6g", temperature[n]);
      text += cells;
    }
    text += "\n";
  }
  return text;
}

}  // namespace

void writeWhole(const fs::path& path, const std::function<void(const fs::path&)>& fill) {
  fs::path beside = path;
  beside += "." + std::to_string(::getpid()) + ".part";
  try {
    if (fs::exists(path) && !fs::is_regular_file(path)) throw std::runtime_error("not a file");
    write(path, beside, fill);
  } catch (const std::exception& error) {
    std::error_code ignored;
    fs::remove(beside, ignored);
    throw std::runtime_error(path.string() + ": cannot be written (" + error.what() + ")");
  }
}

void requireRecordingName(const fs::path& path) {
  if (path.extension() == ".csv" || path.extension() == ".bag") return;
  throw std::invalid_argument(path.string() + ": expected a name ending in .csv or .bag");
}

void writeRecording(const fs::path& path, const std::vector<RecordedSample>& samples, Digits digits,
                    const std::vector<double>& temperature) {
  requireRecordingName(path);
  if (path.extension() == ".csv") return writeText(path, csvOf(samples, digits, temperature));
  writeWhole(path, [&](const fs::path& name) { writeBag(name, samples, temperature); });
}

void writeText(const fs::path& path, const std::string& text) {
  writeWhole(path, [&](const fs::path& name) {
    errno = 0;
    std::ofstream file(name, std::ios::binary);
    file << text;
    file.close();
    if (!file) throw std::system_error(errno != 0 ? errno : EIO, std::generic_category());
  });
}

}  // namespace battery_sof_simulator
