#include "util/regular_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>

namespace battery_sof {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& why) {
  throw std::runtime_error(path.string() + ": " + why);
}

/// An open file that is closed whatever happens.
class OpenFile {
 public:
  // Without O_NONBLOCK opening a pipe waits for its writer.
  explicit OpenFile(const std::filesystem::path& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {
    if (descriptor_ < 0) refuse(path, "cannot be read: " + std::generic_category().message(errno));
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() { ::close(descriptor_); }
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace

std::string readRegularFile(const std::filesystem::path& path, std::size_t largest) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    refuse(path, "is no regular file");
  const OpenFile file(path);
  struct stat facts {};
  if (::fstat(file.descriptor(), &facts) != 0)
    refuse(path, "cannot be read: " + std::generic_category().message(errno));
  if (!S_ISREG(facts.st_mode)) refuse(path, "is no regular file");
  std::string text;
  char block[65536];
  for (ssize_t count = 0; (count = ::read(file.descriptor(), block, sizeof block)) != 0;) {
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse(path, "cannot be read: " + std::generic_category().message(errno));
    text.append(block, static_cast<std::size_t>(count));
    if (text.size() > largest || static_cast<std::size_t>(facts.st_size) > largest)
      refuse(path, "is too large, expected at most " + std::to_string(largest) + " bytes");
  }
  return text;
}

}  // namespace battery_sof
