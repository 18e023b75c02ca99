#include "simulator/generator/draw_scenario_command.hpp"

#include <CLI/CLI.hpp>
#include <ostream>

#include "simulator/generator/catalogue_draft.hpp"
#include "simulator/generator/deep_cycle.hpp"
#include "simulator/generator/law_injection.hpp"
#include "simulator/generator/law_scenario.hpp"
#include "simulator/generator/physical_difference.hpp"
#include "simulator/program_frame.hpp"
#include "simulator/recording_output.hpp"

namespace battery_sof_simulator {
namespace {

struct Arguments {
  Order order;
  InjectionOrder law;
  DifferenceOrder difference;
  std::vector<std::string> causes;
  std::string out, label, into;
  bool list = false;
};

void addOptions(CLI::App& app, Arguments& arguments) {
  Order& order = arguments.order;
  app.add_flag("--list", arguments.list, "print what there is, one \"kind mechanism id\" a line");
  app.add_option("--kind", order.what.kind, "kind of the scenario");
  app.add_option("--mechanism", order.what.mechanism,
                 "of an out-of-catalogue law; the seed chooses");
  app.add_option("--id", order.what.id,
                 "what is added, in kinds that have ids; of laws the seed chooses");
  app.add_option(
      "--drive", order.drive,
      "of laws and their controls: city, start_stop, bench, motorway or turns; the seed chooses");
  app.add_flag("--independent-drive", order.independent_drive,
               "drawn independently of what is added; of laws and their controls for 60 to 3600 s");
  app.add_option("--drive-seed", order.drive_seed,
                 "another drive of the battery and law of --seed; of out_of_catalogue");
  app.add_option("--seed", order.seed, "the same seed gives the same scenario")
      ->check(isSeed)
      ->capture_default_str();
  app.add_option(
      "--duration", order.duration,
      "[s]; 1200, of absent 2400; of laws and their controls the seed chooses 600 to 3600");
  app.add_option(
      "--rate", order.rate,
      "of the recording [Hz]; 100, of laws and their controls the seed chooses 1, 10 or 100");
  app.add_option("--scale", order.scale,
                 "times the strength of what is added, 0: gone; of masked X,Y, one for each")
      ->delimiter(',')
      ->expected(1, 2)
      ->capture_default_str();
  app.add_flag("--quiet", order.quiet, "without noise and quantisation; of catalogue kinds");
  app.add_option(
      "--into", arguments.into,
      "recording, time_s,current_a,voltage_v: put the law of --mechanism and --id into it");
  app.add_option("--cause", arguments.causes,
                 "ID=STRENGTH, of physical_difference: with --into, in place of a law; repeatable");
  app.add_option("--capacity-ah", arguments.difference.capacity_ah,
                 "of the recorded battery, with --cause [Ah]")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--strength", arguments.law.strength, "of the law in a recording")
      ->capture_default_str();
  app.add_option("--r-discharge", arguments.law.r_discharge, "of the recorded battery [Ohm]")
      ->capture_default_str();
  app.add_option("--r-charge", arguments.law.r_charge, "of the recorded battery [Ohm]")
      ->capture_default_str();
  app.add_option("--out", arguments.out, "recording to write: .csv or .bag");
  app.add_option("--label", arguments.label, "what is true of it: .json");
}

/// "slow_diffusion=1.5"
DifferenceOrder::Part partOf(const std::string& text) {
  const auto sign = text.find('=');
  double strength = 0.0;
  if (sign == std::string::npos || !CLI::detail::lexical_cast(text.substr(sign + 1), strength))
    throw std::invalid_argument("--cause: \"" + text + "\", expected ID=STRENGTH");
  return {text.substr(0, sign), strength};
}

void inject(Arguments arguments) {
  if (arguments.out.empty()) throw std::invalid_argument("--out is required");
  const std::vector<RecordedSample> measured = readRecording(arguments.into);
  if (!arguments.causes.empty()) {
    for (const std::string& one : arguments.causes)
      arguments.difference.parts.push_back(partOf(one));
    return writeRecording(arguments.out, withDifference(measured, arguments.difference),
                          Digits::kMany);
  }
  arguments.law.mechanism = arguments.order.what.mechanism;
  arguments.law.id = arguments.order.what.id;
  arguments.law.seed = arguments.order.seed;
  writeRecording(arguments.out, injected(measured, arguments.law), Digits::kMany);
}

void run(const Arguments& arguments, std::ostream& out) {
  if (arguments.list) {
    for (const ScenarioKind& one : scenarioKinds())
      out << one.kind << " " << one.mechanism << " " << one.id << "\n";
    for (const PhysicalCause& one : physicalCauses())
      out << "physical_difference " << one.mechanism << " " << one.id << "\n";
    return;
  }
  if (!arguments.into.empty()) return inject(arguments);
  if (!arguments.causes.empty()) throw std::invalid_argument("--cause goes with --into alone");
  if (arguments.out.empty() || arguments.label.empty())
    throw std::invalid_argument("--out and --label are required");
  requireRecordingName(arguments.out);
  meantBy(arguments.order.what);
  if (isOfCatalogue(arguments.order.what)) {
    const CatalogueDraft draft = drawCatalogue(arguments.order);
    const Simulation simulation = simulate(recordedScenario(draft));
    writeRecording(arguments.out, simulation.samples,
                   draft.order.quiet ? Digits::kMany : Digits::kSensor);
    writeText(arguments.label, labelOf(draft, simulation));
  } else if (arguments.order.what.kind == kDeepCycle) {
    const DeepCycle one = drawDeepCycle(arguments.order);
    writeRecording(arguments.out, one.samples, Digits::kSensor);
    writeText(arguments.label, labelOf(one));
  } else {
    const LawScenario one = drawLawScenario(arguments.order);
    writeRecording(arguments.out, one.samples,
                   one.voltage_step_v == 0.0 ? Digits::kMany : Digits::kSensor);
    writeText(arguments.label, labelOf(one));
  }
}

}  // namespace

int runDrawScenario(const std::vector<std::string>& arguments, std::ostream& out,
                    std::ostream& err) {
  CLI::App app(
      "Draws a scenario for judging a diagnosis: a recording of a simulated battery, and a label "
      "that\n"
      "says what is true of it. Current is positive into the battery.",
      "draw_scenario");
  Arguments parsed;
  addOptions(app, parsed);
  return runProgram(
      app, arguments, "draw_scenario", [&] { run(parsed, out); }, out, err);
}

}  // namespace battery_sof_simulator
