#include "battery_sof/recording/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, int error) {
  throw std::runtime_error("cannot write " + path.string() + ": " +
                           std::generic_category().message(error));
}

/// A file being written; removed again unless it is given its final name.
class Draft {
 public:
  Draft(const fs::path& target, int flags, const fs::path& reported)
      : path_(target), reported_(reported), descriptor_(::open(path_.c_str(), flags, 0666)) {
    if (descriptor_ < 0) fail(reported_, errno);
  }
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;
  ~Draft() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!keep_) ::unlink(path_.c_str());
  }

  void write(const std::string& content) {
    for (std::size_t done = 0; done < content.size();) {
      const ssize_t count = ::write(descriptor_, content.data() + done, content.size() - done);
      if (count < 0 && errno != EINTR) fail(reported_, errno);
      if (count > 0) done += static_cast<std::size_t>(count);
    }
  }

  void keep() { keep_ = true; }

  void renameTo(const fs::path& target) {
    if (::fsync(descriptor_) != 0) fail(reported_, errno);
    if (::close(std::exchange(descriptor_, -1)) != 0) fail(reported_, errno);
    if (std::rename(path_.c_str(), target.c_str()) != 0) fail(reported_, errno);
    keep_ = true;
  }

 private:
  fs::path path_;
  fs::path reported_;
  int descriptor_;
  bool keep_ = false;
};

fs::path pathBeside(const fs::path& target) {
  static std::atomic<unsigned> drafts{0};
  return target.parent_path() / ("." + target.filename().string() + "." +
                                 std::to_string(::getpid()) + "-" + std::to_string(drafts++));
}

}  // namespace

void writeFileAtomically(const fs::path& path, const std::string& content) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (fs::is_directory(status)) fail(path, EISDIR);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    Draft device(path, O_WRONLY | O_CLOEXEC, path);
    device.keep();
    device.write(content);
    return;
  }
  const fs::path target = fs::exists(status) ? fs::canonical(path) : path;
  Draft draft(pathBeside(target), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, path);
  draft.write(content);
  draft.renameTo(target);
}

}  // namespace battery_sof
