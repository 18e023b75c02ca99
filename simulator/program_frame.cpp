#include "simulator/program_frame.hpp"

#include <CLI/CLI.hpp>
#include <csignal>
#include <ostream>

#include "simulator/increasing_root.hpp"
#include "simulator/shown_text.hpp"

namespace battery_sof_simulator {

std::string isSeed(const std::string& text) {
  const bool is_whole = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
  return is_whole ? "" : "\"" + text + "\" is no seed, expected a whole number of 0 or more";
}

int runProgram(CLI::App& app, const std::vector<std::string>& arguments, const std::string& name,
               const std::function<void()>& work, std::ostream& out, std::ostream& err) {
  // a file larger than the process may write fails as one on a full disk does
  std::signal(SIGXFSZ, SIG_IGN);
  // CLI11 takes its arguments from the back.
  std::vector<std::string> backwards(arguments.rbegin(), arguments.rend());
  try {
    app.parse(backwards);
    work();
    return kDone;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, out, err);
    err << name << ": " << shown(error.what()) << "\nRun with --help for more information.\n";
    return kUsage;
  } catch (const NoSolution& error) {
    err << name << ": " << shown(error.what()) << "\n";
    return kNegative;
  } catch (const std::exception& error) {
    err << name << ": " << shown(error.what()) << "\n";
    return kUsage;
  }
}

}  // namespace battery_sof_simulator
