#include "reference/draw_case_command.hpp"

#include <CLI/CLI.hpp>
#include <ostream>

#include "reference/case_label.hpp"
#include "reference/increasing_root.hpp"
#include "reference/recording_output.hpp"

namespace battery_sof_reference {
namespace {

constexpr int kDone = 0, kNegative = 1, kUsage = 2;

struct Arguments {
  CaseKind kind{"", "-"};
  std::uint64_t seed = 1;
  double duration = 1200.0, rate = 100.0;
  std::string out, label;
  bool list = false;
};

void addOptions(CLI::App& app, Arguments& arguments) {
  app.add_flag("--list", arguments.list, "print families and ids, one \"family id\" a line");
  app.add_option("--family", arguments.kind.family, "family of the case");
  app.add_option("--id", arguments.kind.id, "what is added, in families that have ids");
  app.add_option("--seed", arguments.seed, "the same seed gives the same case")
      ->capture_default_str();
  app.add_option("--out", arguments.out, "recording to write: .csv or .bag");
  app.add_option("--label", arguments.label, "what it was made from, and what may be said: .json");
  app.add_option("--duration", arguments.duration, "[s]")->capture_default_str();
  app.add_option("--rate", arguments.rate, "of the recording [Hz]")->capture_default_str();
}

int run(const Arguments& arguments, std::ostream& out) {
  if (arguments.list) {
    for (const CaseKind& kind : caseKinds()) out << kind.family << " " << kind.id << "\n";
    return kDone;
  }
  if (arguments.out.empty() || arguments.label.empty())
    throw std::invalid_argument("--out and --label are required");
  if (!isRecordingName(arguments.out))
    throw std::invalid_argument(arguments.out + ": expected a name ending in .csv or .bag");
  const CaseDraft draft =
      drawCase(arguments.kind, arguments.seed, arguments.duration, arguments.rate);
  const Simulation simulation = simulate(draft.scenario);
  writeRecording(arguments.out, simulation, false);
  writeText(arguments.label, labelOf(arguments.kind, draft, simulation));
  return kDone;
}

int answer(const Arguments& arguments, std::ostream& out, std::ostream& err) {
  try {
    return run(arguments, out);
  } catch (const NoSolution& error) {
    err << "draw_case: " << error.what() << "\n";
    return kNegative;
  } catch (const std::exception& error) {
    err << "draw_case: " << error.what() << "\n";
    return kUsage;
  }
}

}  // namespace

int runDrawCase(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
  CLI::App app(
      "Draws a case for a diagnosis: a recording of a simulated battery, and a label that says\n"
      "what is true of it. Current is positive into the battery.",
      "draw_case");
  Arguments parsed;
  addOptions(app, parsed);
  // CLI11 takes its arguments from the back.
  std::vector<std::string> backwards(arguments.rbegin(), arguments.rend());
  try {
    app.parse(backwards);
  } catch (const CLI::ParseError& error) {
    return app.exit(error, out, err) == 0 ? kDone : kUsage;
  }
  return answer(parsed, out, err);
}

}  // namespace battery_sof_reference
