#include "util/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <stdexcept>
#include <system_error>

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

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
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) fail(path, errno);
  try {
    writeAll(descriptor, content, path);
  } catch (...) {
    ::close(descriptor);
    throw;
  }
  ::close(descriptor);
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

}  // namespace battery_sof
