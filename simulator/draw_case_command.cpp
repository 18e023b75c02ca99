#include "simulator/draw_case_command.hpp"

#include <CLI/CLI.hpp>
#include <optional>
#include <ostream>

#include "simulator/case_label.hpp"
#include "simulator/porous_simulation.hpp"
#include "simulator/program_frame.hpp"
#include "simulator/recording_output.hpp"

namespace battery_sof_reference {
namespace {

struct Arguments {
  CaseKind kind{"", "-"};
  std::uint64_t seed = 1;
  std::optional<double> duration;
  double rate = 100.0;
  std::vector<double> scale{1.0};
  std::string out, label;
  bool list = false, quiet = false;
};

void addOptions(CLI::App& app, Arguments& arguments) {
  app.add_flag("--list", arguments.list, "print families and ids, one \"family id\" a line");
  app.add_option("--family", arguments.kind.mechanism, "family of the case");
  app.add_option("--id", arguments.kind.id, "what is added, in families that have ids");
  app.add_option("--seed", arguments.seed, "the same seed gives the same case")
      ->check(isSeed)
      ->capture_default_str();
  app.add_option("--out", arguments.out, "recording to write: .csv or .bag");
  app.add_option("--label", arguments.label, "what it was made from, and what may be said: .json");
  app.add_option("--duration", arguments.duration, "[s]; 1200, of absent 2400");
  app.add_option("--rate", arguments.rate, "of the recording [Hz]")->capture_default_str();
  app.add_option("--scale", arguments.scale,
                 "times the strength of what is added, 0: gone; of masked X,Y, one for each")
      ->delimiter(',')
      ->expected(1, 2)
      ->capture_default_str();
  app.add_flag("--quiet", arguments.quiet, "without noise and quantisation");
}

void writeCase(const Arguments& arguments) {
  const double duration = arguments.duration.value_or(usualDuration(arguments.kind));
  CaseDraft draft =
      drawCase(arguments.kind, arguments.seed, duration, arguments.rate, arguments.scale);
  draft.quiet = arguments.quiet;
  const Scenario scenario = recordedScenario(draft);
  const Simulation simulation =
      draft.porous ? simulatePorous(scenario, *draft.porous) : simulate(scenario);
  writeRecording(arguments.out, simulation, false, draft.quiet ? Digits::kMany : Digits::kSensor);
  writeText(arguments.label, labelOf(arguments.kind, draft, simulation));
}

void run(const Arguments& arguments, std::ostream& out) {
  if (arguments.list) {
    for (const CaseKind& kind : caseKinds()) out << kind.mechanism << " " << kind.id << "\n";
    return;
  }
  if (arguments.out.empty() || arguments.label.empty())
    throw std::invalid_argument("--out and --label are required");
  if (!isRecordingName(arguments.out))
    throw std::invalid_argument(arguments.out + ": expected a name ending in .csv or .bag");
  writeCase(arguments);
}

}  // namespace

int runDrawCase(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
  CLI::App app(
      "Draws a case for a diagnosis: a recording of a simulated battery, and a label that says\n"
      "what is true of it. Current is positive into the battery.",
      "draw_case");
  Arguments parsed;
  addOptions(app, parsed);
  return runProgram(
      app, arguments, "draw_case", [&] { run(parsed, out); }, out, err);
}

}  // namespace battery_sof_reference
