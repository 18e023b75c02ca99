#include "simulator/draw_out_of_model_command.hpp"

#include <CLI/CLI.hpp>
#include <ostream>

#include "simulator/out_of_model_beside.hpp"
#include "simulator/out_of_model_label.hpp"
#include "simulator/program_frame.hpp"
#include "simulator/recording_output.hpp"

namespace battery_sof_reference {
namespace {

struct Arguments {
  OutOfModelOrder order;
  BesideOrder law;
  std::string out, label, beside;
  bool list = false;
};

void addOptions(CLI::App& app, Arguments& arguments) {
  OutOfModelOrder& order = arguments.order;
  app.add_flag("--list", arguments.list, "print what there is, one \"kind mechanism form\" a line");
  app.add_option("--kind", order.kind, "null, imperfect_null or other_form")->capture_default_str();
  app.add_option("--mechanism", order.mechanism, "of other_form; the seed chooses");
  app.add_option("--form", order.form, "of other_form; the seed chooses");
  app.add_option("--drive", order.drive,
                 "city, start_stop, bench, motorway or turns; the seed chooses");
  app.add_option("--seed", order.seed, "the same seed gives the same case")
      ->check(isSeed)
      ->capture_default_str();
  app.add_option("--duration", order.duration, "[s]; the seed chooses 600 to 3600");
  app.add_option("--rate", order.rate, "of the recording [Hz]; the seed chooses 1, 10 or 100");
  app.add_option("--scale", order.scale, "times the strength, 0: the base circuit")
      ->capture_default_str();
  app.add_option(
      "--beside", arguments.beside,
      "recording, time_s,current_a,voltage_v: put the law of --mechanism and --form into it");
  app.add_option("--strength", arguments.law.strength, "of the law beside a recording")
      ->capture_default_str();
  app.add_option("--r-discharge", arguments.law.r_discharge, "of the battery beside [Ohm]")
      ->capture_default_str();
  app.add_option("--r-charge", arguments.law.r_charge, "of the battery beside [Ohm]")
      ->capture_default_str();
  app.add_option("--out", arguments.out, "recording to write: .csv or .bag");
  app.add_option("--label", arguments.label, "what is true of it: .json");
}

void runBeside(Arguments arguments) {
  if (arguments.out.empty()) throw std::invalid_argument("--out is required");
  arguments.law.mechanism = arguments.order.mechanism;
  arguments.law.form = arguments.order.form;
  arguments.law.seed = arguments.order.seed;
  Simulation recording;
  recording.samples = besideRecording(readRecording(arguments.beside), arguments.law);
  writeRecording(arguments.out, recording, false, Digits::kMany);
}

void run(const Arguments& arguments, std::ostream& out) {
  if (arguments.list) {
    for (const OutOfModelKind& one : outOfModelKinds())
      out << one.kind << " " << one.mechanism << " " << one.form << "\n";
    return;
  }
  if (!arguments.beside.empty()) return runBeside(arguments);
  if (arguments.out.empty() || arguments.label.empty())
    throw std::invalid_argument("--out and --label are required");
  if (!isRecordingName(arguments.out))
    throw std::invalid_argument(arguments.out + ": expected a name ending in .csv or .bag");
  const OutOfModelCase one = drawOutOfModelCase(arguments.order);
  Simulation recording;
  recording.samples = one.samples;
  const bool plain = one.voltage_step_v == 0.0;
  writeRecording(arguments.out, recording, false, plain ? Digits::kMany : Digits::kSensor);
  writeText(arguments.label, labelOf(one));
}

}  // namespace

int runDrawOutOfModel(const std::vector<std::string>& arguments, std::ostream& out,
                      std::ostream& err) {
  CLI::App app(
      "Draws a case whose physics has a form that no catalogue has, or a null, for judging a\n"
      "diagnosis. Current is positive into the battery.",
      "draw_out_of_model");
  Arguments parsed;
  addOptions(app, parsed);
  return runProgram(
      app, arguments, "draw_out_of_model", [&] { run(parsed, out); }, out, err);
}

}  // namespace battery_sof_reference
