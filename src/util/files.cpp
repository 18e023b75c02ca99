#include "util/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <stdexcept>
#include <system_error>

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

/// An open file's descriptor, closed whatever happens.
class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  operator int() const { return descriptor_; }

 private:
  int descriptor_;
};

[[noreturn]] void fail(const fs::path& path, int error) {
  throw std::runtime_error("cannot write " + path.string() + ": " +
                           std::generic_category().message(error));
}

/// A file being written that has no name until it is complete, where the file system can do that: a
/// process that is ended leaves nothing behind. Elsewhere it has a name of its own, and is removed
/// again unless it is given its final one.
class Draft {
 public:
  Draft(const fs::path& place, const fs::path& reported) : path_(place), reported_(reported) {
    const fs::path folder = place.has_parent_path() ? place.parent_path() : ".";
    descriptor_ = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
    has_name_ = descriptor_ < 0;
    if (has_name_)
      descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) fail(reported_, errno);
  }
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;
  ~Draft() {
    ::close(descriptor_);
    if (has_name_) ::unlink(path_.c_str());
  }

  int descriptor() const { return descriptor_; }
  fs::path name() const {
    return has_name_ ? path_ : fs::path("/proc/self/fd/" + std::to_string(descriptor_));
  }

  void renameTo(const fs::path& target) {
    if (::fsync(descriptor_) != 0) fail(reported_, errno);
    if (!has_name_ &&
        ::linkat(AT_FDCWD, name().c_str(), AT_FDCWD, path_.c_str(), AT_SYMLINK_FOLLOW) != 0)
      fail(reported_, errno);
    has_name_ = true;
    if (std::rename(path_.c_str(), target.c_str()) != 0) fail(reported_, errno);
    has_name_ = false;
  }

 private:
  fs::path path_;
  fs::path reported_;
  int descriptor_ = -1;
  bool has_name_ = false;
};

void writeAll(int descriptor, const std::string& content, const fs::path& reported) {
  for (std::size_t done = 0; done < content.size();) {
    const ssize_t count = ::write(descriptor, content.data() + done, content.size() - done);
    if (count < 0 && errno != EINTR) fail(reported, errno);
    if (count > 0) done += static_cast<std::size_t>(count);
  }
}

void writeDevice(const fs::path& path, const std::string& content) {
  const Descriptor device(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (device < 0) fail(path, errno);
  writeAll(device, content, path);
}

fs::path pathBeside(const fs::path& target) {
  static std::atomic<unsigned> drafts{0};
  return target.parent_path() / ("." + target.filename().string() + "." +
                                 std::to_string(::getpid()) + "-" + std::to_string(drafts++));
}

/// What is there, links followed. @throws std::runtime_error for a folder and for what the system
/// cannot say (a loop of links).
fs::file_status writableStatus(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::none) fail(path, error.value());
  if (fs::is_directory(status)) fail(path, EISDIR);
  return status;
}

bool isCompared(const std::string& name) {
  std::error_code ignored;
  const fs::file_status status = fs::status(name, ignored);
  return !name.empty() && name != "-" && (!fs::exists(status) || fs::is_regular_file(status));
}

fs::path placeOf(const fs::path& name) {
  std::error_code ignored;
  const fs::path folder = fs::weakly_canonical(fs::absolute(name, ignored).parent_path(), ignored);
  return folder / name.filename();
}

bool isOneFile(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored) || placeOf(a) == placeOf(b);
}

}  // namespace

fs::path linkTarget(const fs::path& path) {
  constexpr int kMaxLinks = 40;  // as Linux
  std::error_code none;
  fs::path target = path;
  for (int links = 0; fs::is_symlink(target, none); ++links) {
    if (links == kMaxLinks) return path;
    const fs::path next = fs::read_symlink(target, none);
    if (none) return path;
    target = target.parent_path() / next;
  }
  return target;
}

void writeFileAtomically(const fs::path& path, const std::string& content) {
  const fs::file_status status = writableStatus(path);
  if (fs::exists(status) && !fs::is_regular_file(status)) return writeDevice(path, content);
  const fs::path target = linkTarget(path);
  Draft draft(pathBeside(target), path);
  writeAll(draft.descriptor(), content, path);
  draft.renameTo(target);
}

void writeFileAtomically(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  const fs::file_status status = writableStatus(path);
  if (fs::exists(status) && !fs::is_regular_file(status)) fail(path, EINVAL);
  const fs::path target = linkTarget(path);
  Draft draft(pathBeside(target), path);
  write(draft.name());
  draft.renameTo(target);
}

std::string readRegularFile(const fs::path& path, std::size_t largest) {
  const auto refuse = [&path](const std::string& why) {
    throw std::runtime_error(path.string() + ": " + why);
  };
  const auto refuse_reading = [&refuse] {
    refuse("cannot be read: " + std::generic_category().message(errno));
  };
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) refuse("is not a regular file");
  // Without O_NONBLOCK opening a pipe waits for its writer.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  struct stat facts {};
  if (file < 0 || ::fstat(file, &facts) != 0) refuse_reading();
  if (!S_ISREG(facts.st_mode)) refuse("is not a regular file");
  std::string text;
  char block[65536];
  for (ssize_t count = 0; (count = ::read(file, block, sizeof block)) != 0;) {
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse_reading();
    text.append(block, static_cast<std::size_t>(count));
    if (text.size() > largest || static_cast<std::size_t>(facts.st_size) > largest)
      refuse("is too large, expected at most " + std::to_string(largest) + " bytes");
  }
  return text;
}

void requireSeparateFiles(const std::vector<std::string>& read,
                          const std::vector<std::string>& written) {
  for (std::size_t k = 0; k < written.size(); ++k) {
    if (!isCompared(written[k])) continue;
    for (const std::string& input : read)
      if (isCompared(input) && isOneFile(input, written[k]))
        throw std::invalid_argument(written[k] + " would be written over " + input +
                                    ", which is read: expected another file");
    for (std::size_t j = 0; j < k; ++j)
      if (isCompared(written[j]) && isOneFile(written[j], written[k]))
        throw std::invalid_argument(written[k] + " and " + written[j] +
                                    " are one file to write: expected two");
  }
}

}  // namespace battery_sof
