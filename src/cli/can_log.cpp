#include "can_log.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "battery_sof/recording_error.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

constexpr char kProgram[] = "can_log";
constexpr int kNotRun = 127;  // exit code of a program that could not be started

/// can_log beside the running program; its name alone where it is not there.
std::string programPath() {
  std::error_code none;
  const fs::path beside = fs::read_symlink("/proc/self/exe", none).parent_path() / kProgram;
  return ::access(beside.c_str(), X_OK) == 0 ? beside.string() : kProgram;
}

/// Runs a program to its end. @param messages file that takes what it says.
/// @return its exit code, kNotRun where it does not run.
int run(std::vector<std::string> words, const fs::path& messages) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, messages.c_str(), O_WRONLY | O_CREAT,
                                   0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t child = 0;
  const int error =
      posix_spawnp(&child, arguments.front(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return kNotRun;
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return kNotRun;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kNotRun;
}

fs::path temporaryFolder() {
  std::string name = (fs::temp_directory_path() / "sof-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    throw RecordingError(name + ": cannot be made: " + std::generic_category().message(errno));
  return name;
}

}  // namespace

bool isCanLog(const std::string& path) {
  std::error_code none;
  if (!fs::is_regular_file(path, none)) return false;
  std::array<char, 8> bytes{};
  std::ifstream(path, std::ios::binary).read(bytes.data(), bytes.size());
  const std::string_view first(bytes.data(), bytes.size());
  const auto begins = [&](std::string_view magic) {
    return first.substr(0, magic.size()) == magic;
  };
  const bool is_asc = fs::path(path).extension() == ".asc" && begins("date ");
  return begins("LOGG") || begins("MDF  ") || begins("UnFinMF") || is_asc;
}

std::string canLogAdvice(const std::string& path) {
  return path +
         ": is a log of a CAN bus, expected a bag or a CSV file. This makes one of it: sof "
         "convert " +
         path + " " + fs::path(path).stem().string() +
         ".csv --dbc FILE.dbc --current-column SIGNAL --voltage-column SIGNAL";
}

CanLogAsCsv::CanLogAsCsv(const std::string& log, const CanSignals& signals)
    : folder_(temporaryFolder()), name_(fs::path(log).filename().string() + ".csv") {
  const std::string program = programPath();
  std::vector<std::string> words = {program, "--current", signals.current, "--voltage",
                                    signals.voltage};
  if (signals.temperature) words.insert(words.end(), {"--temperature", *signals.temperature});
  if (signals.discharge_positive) words.emplace_back("--discharge-positive");
  words.insert(words.end(), {"--", log, signals.dbc, path()});
  const fs::path messages = folder_ / "messages";
  const int code = run(words, messages);
  if (code == 0) return;
  std::ifstream file(messages);
  std::string said{std::istreambuf_iterator<char>(file), {}};
  while (!said.empty() && said.back() == '\n') said.pop_back();
  std::error_code none;
  fs::remove_all(folder_, none);
  if (code == kNotRun)
    said =
        "the program " + program +
        " cannot be run, expected it beside sof or on the PATH: it needs Python 3 and comes with "
        "the package battery-sof, and as scripts/can_log with its source";
  throw RecordingError(said.find(log) == std::string::npos ? log + ": " + said : said);
}

CanLogAsCsv::~CanLogAsCsv() {
  std::error_code none;
  fs::remove_all(folder_, none);
}

}  // namespace battery_sof
