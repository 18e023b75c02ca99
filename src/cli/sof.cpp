#include "battery_sof/cli/sof.hpp"

#include <algorithm>
#include <ostream>

#include "battery_sof/report/version.hpp"
#include "command.hpp"

namespace battery_sof {
namespace {

int parseAndRun(CLI::App& app, CommandLine& line, std::vector<std::string> arguments) {
  // CLI11 takes its arguments from the back.
  std::reverse(arguments.begin(), arguments.end());
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error, line.out, line.err) == 0 ? kExitDone : kExitUsage;
  }
  return line.run();
}

}  // namespace

int runSof(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err,
           const std::vector<ExternalCommand>& external) {
  for (const auto& command : external)
    if (!arguments.empty() && arguments[0] == command.name)
      return command.run({arguments.begin() + 1, arguments.end()}, out, err);
  CLI::App app(
      "What a vehicle's 12 V battery can still do, from the current and voltage of driving.\n"
      "Current is positive into the battery. Exit: 0 done, 1 an honest negative outcome, "
      "2 wrong usage or input.",
      "sof");
  app.set_version_flag("--version", "sof " + version());
  app.require_subcommand(1);
  CommandLine line{out, err, nullptr};
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
  try {
    return parseAndRun(app, line, arguments);
  } catch (const std::exception& error) {
    err << "sof: " << error.what() << "\n";
    return kExitUsage;
  }
}

}  // namespace battery_sof
