#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace battery_sof {

/// Exit codes of the command.
enum ExitCode : int {
  kExitDone = 0,      ///< an answer was given
  kExitNegative = 1,  ///< an honest negative outcome; the message says which
  kExitUsage = 2,     ///< wrong usage or unusable input
};

/// A subcommand that lives outside the product and is only started from here (the reference
/// simulator).
struct ExternalCommand {
  std::string name, description;
  /// Takes the arguments after the name; returns an ExitCode.
  std::function<int(const std::vector<std::string>&, std::ostream&, std::ostream&)> run;
};

/**
 * @brief The command `sof`, without the process around it.
 * @param arguments without the program's name.  @param out, err standard output and error.
 * @return an ExitCode. Never throws; an error is one line on err, and one more on how to call. From
 * then on the process ignores SIGXFSZ: writing beyond its limit on a file's size is such an error,
 * not its end.
 */
int runSof(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err,
           const std::vector<ExternalCommand>& external = {});

}  // namespace battery_sof
