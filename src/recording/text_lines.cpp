#include "recording/text_lines.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "battery_sof/recording_error.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlock = 1 << 16;  // [bytes]
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

[[noreturn]] void refuse(const fs::path& path, const std::string& why) {
  throw RecordingError(path.string() + ": " + why);
}

std::string because(int error) {
  return "cannot be read: " + std::generic_category().message(error);
}

/// Opening a device may have effects, so it is looked at first.
int opened(const fs::path& path) {
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) refuse(path, because(errno));
  if (S_ISDIR(facts.st_mode)) refuse(path, "is a directory, expected a file or a pipe");
  if (!S_ISREG(facts.st_mode) && !S_ISFIFO(facts.st_mode))
    refuse(path, "is a device or a socket, expected a file or a pipe");
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_NOCTTY | O_CLOEXEC);
  if (descriptor < 0) refuse(path, because(errno));
  return descriptor;
}

}  // namespace

TextLines::TextLines(const fs::path& path, BytesSeen seen)
    : path_(path), seen_(std::move(seen)), descriptor_(opened(path)) {}

TextLines::~TextLines() { ::close(descriptor_); }

bool TextLines::next() {
  while (nextOfAny())
    if (line_.find_first_not_of(" \t\r") != std::string_view::npos) return true;
  return false;
}

bool TextLines::nextOfAny() {
  std::size_t end = held_.find('\n', at_);
  while (end == std::string::npos && held_.size() - at_ <= kLongest) {
    const std::size_t searched = held_.size() - at_;
    if (!readOn()) break;
    end = held_.find('\n', searched);
  }
  finished_ = end != std::string::npos;
  line_ = std::string_view(held_).substr(at_, finished_ ? end - at_ : std::string::npos);
  if (line_.empty() && !finished_) return false;
  ++number_;
  if (line_.size() > kLongest)
    refuse(path_, "line " + std::to_string(number_) +
                      " is too long, expected a CSV file with lines of at most " +
                      std::to_string(kLongest) + " bytes");
  at_ += line_.size() + (finished_ ? 1 : 0);
  if (number_ == 1 && line_.substr(0, kByteOrderMark.size()) == kByteOrderMark)
    line_.remove_prefix(kByteOrderMark.size());
  return true;
}

/// Drops what is done with and reads a block behind the rest. @return false at the end.
bool TextLines::readOn() {
  held_.erase(0, at_);
  at_ = 0;
  const std::size_t before = held_.size();
  held_.resize(before + kBlock);
  ssize_t count = 0;
  do count = ::read(descriptor_, held_.data() + before, kBlock);
  while (count < 0 && errno == EINTR);
  if (count < 0) refuse(path_, because(errno));
  held_.resize(before + static_cast<std::size_t>(count));
  if (seen_ && count > 0) seen_(std::string_view(held_).substr(before));
  return count > 0;
}

}  // namespace battery_sof
