#include "cli/sof.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <new>
#include <ostream>
#include <system_error>

#include "battery_sof/version.hpp"
#include "command.hpp"
#include "util/files.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

std::vector<std::string> filesOf(CLI::App& command, const std::string& type) {
  std::vector<std::string> files;
  for (const CLI::Option* option : command.get_options())
    if (option->get_type_name() == type && option->count() > 0)
      for (const std::string& file : option->results()) files.push_back(file);
  return files;
}

/// CLI11 takes hexadecimal numbers too, and turns negative ones round where none below 0 are
/// expected. What is not finite is refused by whoever the number is for.
void requireDecimals(CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    const std::string type =
        option->get_type_name().substr(0, option->get_type_name().find_first_of(": "));
    const bool is_unsigned = type == "UINT";
    if (!is_unsigned && type != "INT" && type != "FLOAT") continue;
    for (const std::string& text : option->results())
      if (text != "nan" && text.find_first_not_of(is_unsigned ? "0123456789" : "0123456789+-.eE") !=
                               std::string::npos)
        throw UsageError(option->get_name() + " is \"" + text + "\", expected a " +
                         (is_unsigned ? "whole number of 0 or more" : "decimal number"));
  }
}

/// Help that was asked for, or what is wrong with the usage, which holds pieces of the command
/// line.
int refusalOf(CLI::App& app, const CLI::ParseError& error, CommandLine& line) {
  if (error.get_exit_code() == 0) {
    app.exit(error, line.out, line.err);
    return kExitDone;
  }
  complain(line.err, error.what());
  line.err << "Run with --help for more information.\n";
  return kExitUsage;
}

/// What was said must have arrived: standard output may be a file on a full disk.
int arrived(std::ostream& out, std::ostream& err, int code) {
  if (out.flush()) return code;
  complain(err, "standard output cannot be written: " +
                    std::generic_category().message(errno != 0 ? errno : EIO));
  return kExitUsage;
}

int parseAndRun(CLI::App& app, CommandLine& line, std::vector<std::string> arguments) {
  // CLI11 takes its arguments from the back.
  std::reverse(arguments.begin(), arguments.end());
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    return refusalOf(app, error, line);
  }
  for (CLI::App* command : app.get_subcommands()) {
    requireDecimals(*command);
    requireSeparateFiles(filesOf(*command, kReadFile), filesOf(*command, kWrittenFile));
  }
  return line.run();
}

int runCommand(CommandLine& line, const std::vector<std::string>& arguments,
               const std::vector<ExternalCommand>& external) {
  for (const auto& command : external)
    if (!arguments.empty() && arguments[0] == command.name)
      return command.run({arguments.begin() + 1, arguments.end()}, line.out, line.err);
  CLI::App app(
      "Predicts what a vehicle's 12 V battery can still do, from current and voltage recorded "
      "while driving.\nCurrent is positive into the battery. Exit codes: 0 done, 1 a negative "
      "outcome (the message says which), 2 wrong usage or input.",
      "sof");
  app.set_version_flag("--version", "sof " + version());
  app.require_subcommand(1);
  addCheckCommand(app, line);
  addConvertCommand(app, line);
  addIdentifyCommand(app, line);
  addPredictCommand(app, line);
  addCrankCommand(app, line);
  addStopTimeCommand(app, line);
  addChargeCommand(app, line);
  addMapCommand(app, line);
  addDiagnoseCommand(app, line);
  addEffectsCommand(app, line);
  for (const auto& command : external) app.add_subcommand(command.name, command.description);
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](CLI::App*) { return true; }))
    names.push_back(command->get_name());
  if (!arguments.empty() && arguments[0].rfind('-', 0) != 0 && !contains(names, arguments[0]))
    throw UsageError("sof " + arguments[0] + " is not a command, expected one of " + join(names));
  return parseAndRun(app, line, arguments);
}

}  // namespace

int runSof(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err,
           const std::vector<ExternalCommand>& external) {
  // a file larger than the process may write fails as one on a full disk does
  std::signal(SIGXFSZ, SIG_IGN);
  CommandLine line{out, err, nullptr};
  try {
    return arrived(out, err, runCommand(line, arguments, external));
  } catch (const std::bad_alloc&) {
    complain(err, "out of memory");
    return kExitUsage;
  } catch (const std::exception& error) {
    complain(err, error.what());
    return kExitUsage;
  }
}

}  // namespace battery_sof
