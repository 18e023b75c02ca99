#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <iosfwd>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "bag/bag_storage.hpp"
#include "battery_sof/csv.hpp"
#include "cli/sof.hpp"
#include "estimation/parameter_space.hpp"
#include "progress.hpp"
#include "recording/resample.hpp"

namespace battery_sof {

/// Input or usage that cannot be worked with; becomes exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Streams and the function that the chosen subcommand runs.
struct CommandLine {
  std::ostream& out;
  std::ostream& err;
  std::function<int()> run;
};

/// A subcommand, and where its options put their values.
template <typename Arguments>
struct Subcommand {
  CLI::App& options;
  Arguments& values;
};

/// Adds a subcommand that runs a function with its arguments.
template <typename Arguments>
Subcommand<Arguments> addSubcommand(CLI::App& app, CommandLine& line, const std::string& name,
                                    const std::string& description,
                                    int (*run)(const CommandLine&, const Arguments&)) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(name, description);
  command->callback([&line, arguments, run] {
    line.run = [&line, arguments, run] { return run(line, *arguments); };
  });
  return {*command, *arguments};
}

/// Type names, shown by --help, of options that name files: runSof() refuses a file that is both
/// read and written.
inline constexpr char kReadFile[] = "INPUT";
inline constexpr char kWrittenFile[] = "OUTPUT";
inline constexpr char kJsonOption[] = "--json";

/// An option that takes a value; --help shows its default where there is one.
template <typename Value>
CLI::Option* addOption(CLI::App& command, const std::string& name, Value& value,
                       const std::string& description) {
  CLI::Option* option = command.add_option(name, value, description);
  if constexpr (std::is_arithmetic_v<Value> || std::is_same_v<Value, std::string>)
    option->capture_default_str();
  return option;
}
template <typename Value>
void addRequired(CLI::App& command, const std::string& name, Value& value,
                 const std::string& description) {
  command.add_option(name, value, description)->required();
}
/// Ids or numbers, comma-separated.
template <typename Value>
CLI::Option* addList(CLI::App& command, const std::string& name, std::vector<Value>& list,
                     const std::string& description) {
  return command.add_option(name, list, description)->delimiter(',');
}
/// Ids of effects, comma-separated; the completion offers them by the type that --help shows.
inline CLI::Option* addEffectIds(CLI::App& command, const std::string& name,
                                 std::vector<std::string>& ids, const std::string& description) {
  return addList(command, name, ids, description)->type_name("ID");
}
/// @param kind kReadFile or kWrittenFile. @param path or paths; "" is none, "-" no file to write.
template <typename Path>
CLI::Option* addFile(CLI::App& command, const char* kind, const std::string& name, Path& path,
                     const std::string& description) {
  const bool may_be_output = kind == kReadFile || name == kJsonOption;
  const auto fault = [may_be_output](const std::string& given) -> std::string {
    const bool is_name = !given.empty() && (may_be_output || given != "-");
    return is_name ? "" : "is \"" + given + "\", expected the name of a file";
  };
  return command.add_option(name, path, description)->type_name(kind)->check(fault);
}

/// How a recording is named on the command line.
struct RecordingArguments {
  std::string path;
  CsvColumns columns;
  std::string topic = kDefaultTopic;
  double series_blocks = 1.0;                          ///< 12 V blocks in series
  std::optional<double> crank_current = std::nullopt;  ///< [A], below 0; none: read off it
  std::string time_unit;  ///< of the CSV's time column: s, ms or us; empty: by its name
};

/// The options --from and --to, as typed.
struct WindowArguments {
  std::string from, to;
};

/// What other batteries say beforehand.
struct PriorsArguments {
  std::string file, vehicle_type;
};

inline constexpr char kRecordingFile[] = "recording: .bag, .csv, or CSV from a pipe";
void addModelOption(CLI::App& command, std::string& model);
void addRecordingOptions(CLI::App& command, RecordingArguments& arguments, bool with_path = true);
/// An option of 0.2 under its old name: refused with the new one, or "gone".
void addRenamedOption(CLI::App& command, const std::string& old, const std::string& now);

/// The option --crank-current, of either sign: the current of a crank is always out of the battery.
void addCrankCurrentOption(CLI::App& command, RecordingArguments& arguments);
/// @throws UsageError for a --capacity-ah that is not above 0 and finite.
void requireCapacity(const std::optional<double>& capacity_ah);
void addSeriesBlocksOption(CLI::App& command, RecordingArguments& arguments);
void addWindowOptions(CLI::App& command, WindowArguments& arguments);
void addPriorsOptions(CLI::App& command, PriorsArguments& arguments);

/// The option --anyway: a recording with a problem is not refused.
void addAnywayOption(CLI::App& command, bool& anyway);
void addJsonOption(CLI::App& command, std::string& json);

/// Reads a bag or CSV file, with the voltage of one of its blocks. A pipe is read once, as CSV.
/// @param hash takes "sha256:" and the digest of the bytes that were read. @throws RecordingError,
/// UsageError.
/// @param notes takes what was assumed of the file, which is on standard error as well.
Recording loadRecording(const RecordingArguments& arguments, std::string* hash = nullptr,
                        std::vector<std::string>* notes = nullptr);

/// @return nothing without a file. @throws ModelFileError, UsageError.
std::vector<KnownPopulation> loadPriors(const PriorsArguments& arguments);

/**
 * @brief A time of the command line on the recording's clock [s].
 *
 * "+T" counts from the first sample. A plain T below 1e8 does so too when the recording's clock
 * counts from 1970 (its first stamp is above 1e8 s): no such recording holds the year 1973.
 * @throws UsageError when it is not a number.
 */
std::optional<double> parseTime(const std::string& text, const Series& series, const char* option);

/// @return samples between --from and --to. @throws std::invalid_argument when there are none.
IndexRange rangeOf(const WindowArguments& arguments, const Series& series);

/// Prints text, or JSON instead when json is "-"; writes JSON to a file when json names one. Line
/// breaks of the text are the writer's own: a name of outside in it is made printable() before.
void emit(const CommandLine& line, const std::string& text, const nlohmann::json& json,
          const std::string& json_target);

/// One line on standard error, beginning with "sof: ", whatever the sentence holds of files and
/// command lines: control characters are shown as their codes, and what is longer than two paths is
/// cut off.
void complain(std::ostream& err, const std::string& what);

void addCheckCommand(CLI::App& app, CommandLine& line);
void addConvertCommand(CLI::App& app, CommandLine& line);
void addIdentifyCommand(CLI::App& app, CommandLine& line);
void addPredictCommand(CLI::App& app, CommandLine& line);
void addCrankCommand(CLI::App& app, CommandLine& line);
void addStopTimeCommand(CLI::App& app, CommandLine& line);
void addChargeCommand(CLI::App& app, CommandLine& line);
void addMapCommand(CLI::App& app, CommandLine& line);
void addDiagnoseCommand(CLI::App& app, CommandLine& line);
void addEffectsCommand(CLI::App& app, CommandLine& line);

}  // namespace battery_sof
