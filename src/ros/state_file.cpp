#include "ros/state_file.hpp"

#include <signal.h>

#include <cstdlib>
#include <exception>
#include <system_error>

#include "report/model_yaml.hpp"
#include "util/files.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

/// Why a path cannot hold a state file; none when it can.
std::optional<std::string> faultOf(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found || fs::is_regular_file(status)) return std::nullopt;
  const std::string why = error ? error.message() : "it is not a regular file";
  return printable(path.string()) + " cannot be used: " + why;
}

/// What writeFileAtomically() of a process that was killed left behind: ".NAME.PID-NUMBER".
void removeDrafts(const fs::path& path) {
  const std::string begin = "." + path.filename().string() + ".";
  std::error_code error;
  for (fs::directory_iterator entry(fs::absolute(path, error).parent_path(), error), end;
       !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.compare(0, begin.size(), begin) != 0) continue;
    char* rest = nullptr;
    const long process = std::strtol(name.c_str() + begin.size(), &rest, 10);
    std::error_code ignored;
    const bool is_gone = ::kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH;
    if (process > 0 && *rest == '-' && is_gone) fs::remove(entry->path(), ignored);
  }
}

/// FILE.refused, and FILE.refused.1, .2 ... where that is taken.
fs::path freeName(const fs::path& file) {
  fs::path first = file;
  first += ".refused";
  fs::path free = first;
  std::error_code none;
  for (int n = 1; fs::exists(fs::symlink_status(free, none)); ++n)
    (free = first) += "." + std::to_string(n);
  return free;
}

}  // namespace

StateFile::Result StateFile::read() const {
  if (path_.empty()) return {};
  const std::string name = printable(path_.string());
  if (const auto fault = faultOf(path_)) return {"no saved model was loaded: " + *fault, true};
  try {
    removeDrafts(linkTarget(path_));
    if (!fs::exists(path_)) return {"there is no saved model in " + name + " yet"};
    return {"loaded the saved model from " + name, false, readModelFile(path_)};
  } catch (const std::exception& error) {
    return {"the saved model is not used: " + printable(error.what()) + "; " + setAside(), true};
  }
}

StateFile::Result StateFile::save(const FittedModel& model) const {
  if (path_.empty()) return {};
  if (const auto fault = faultOf(path_)) return {"the model cannot be saved: " + *fault, true};
  try {
    const std::string text = modelYaml(model);
    parseModelYaml(text, path_.string());
    if (path_.has_parent_path()) fs::create_directories(path_.parent_path());
    writeFileAtomically(path_, text);
  } catch (const std::exception& error) {
    return {"the model cannot be saved: " + printable(error.what()), true};
  }
  return {};
}

std::string StateFile::setAside() const {
  const fs::path file = linkTarget(path_), aside = freeName(file);
  std::error_code error;
  fs::rename(file, aside, error);
  return error ? "it could not be set aside: " + error.message()
               : "it was set aside as " + printable(aside.string());
}

}  // namespace battery_sof
