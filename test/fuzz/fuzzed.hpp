#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

/// What fuzz targets share.
namespace battery_sof::fuzz {

/// Ends the program, so that the input is kept, when a law is broken. @param broken the law; empty
/// when none is.
inline void require(const std::string& broken) {
  if (broken.empty()) return;
  std::fprintf(stderr, "broken: %s\n", broken.c_str());
  std::abort();
}
inline void require(bool holds, const char* law) { require(holds ? "" : std::string(law)); }

/// A file in memory, for readers that want a path.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(::memfd_create("fuzzed", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw std::runtime_error("no file in memory can be made");
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { ::close(descriptor_); }

  /// Replaces the content.
  void fill(const void* data, std::size_t size) {
    const bool is_filled = ::ftruncate(descriptor_, 0) == 0 &&
                           ::pwrite(descriptor_, data, size, 0) == static_cast<ssize_t>(size);
    if (!is_filled) throw std::runtime_error("the file in memory cannot be written");
  }
  std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

}  // namespace battery_sof::fuzz
