#include "simulator/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <stdexcept>
#include <string>
#include <system_error>

namespace battery_sof_simulator {
namespace {

namespace fs = std::filesystem;

/// A file without a name in a folder.
class Nameless {
 public:
  explicit Nameless(const fs::path& folder)
      : descriptor_(
            ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666)) {}
  Nameless(const Nameless&) = delete;
  Nameless& operator=(const Nameless&) = delete;
  ~Nameless() {
    if (exists()) ::close(descriptor_);
  }
  bool exists() const { return descriptor_ >= 0; }
  fs::path name() const { return "/proc/self/fd/" + std::to_string(descriptor_); }
  bool linkTo(const fs::path& path) const {
    return ::linkat(AT_FDCWD, name().c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) == 0;
  }

 private:
  int descriptor_;
};

void write(const fs::path& path, const fs::path& beside,
           const std::function<void(const fs::path&)>& fill) {
  const Nameless draft(path.parent_path());
  fill(draft.exists() ? draft.name() : beside);
  if (draft.exists() && draft.linkTo(path)) return;
  if (draft.exists() && !draft.linkTo(beside))
    throw std::system_error(errno, std::generic_category());
  fs::rename(beside, path);
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

}  // namespace battery_sof_simulator
