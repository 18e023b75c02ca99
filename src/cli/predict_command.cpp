#include <cstdio>

#include "battery_sof/predict/both_ways.hpp"
#include "battery_sof/recording/atomic_file.hpp"
#include "battery_sof/report/model_yaml.hpp"
#include "battery_sof/report/results.hpp"
#include "command.hpp"

namespace battery_sof {
namespace {

struct PredictArguments {
  std::string model;
  RecordingArguments recording;
  WindowArguments window;
  std::string csv, json, drive;
};

/// The current drives throughout: what drives is as measured.
FollowedPrediction currentDriven(const FittedModel& model, const Series& series, IndexRange range) {
  const PredictedVoltage voltage = predictSeries(model, series, range);
  FollowedPrediction predicted;
  predicted.voltage_drives.assign(range.size(), 0);
  predicted.voltage = predicted.equations_voltage = voltage.voltage;
  predicted.voltage_lower = voltage.lower;
  predicted.voltage_upper = voltage.upper;
  const Series part = slice(series, range);
  predicted.current = predicted.current_lower = predicted.current_upper = part.current;
  return predicted;
}

std::string predictionCsv(const Series& series, IndexRange range, const FollowedPrediction& predicted) {
  std::string text = "time_s,current_a,voltage_v,predicted_v,lower_v,upper_v,driven_by,predicted_a,lower_a,upper_a\n";
  for (std::size_t n = range.first; n < range.last; ++n) {
    const std::size_t k = n - range.first;
    char row[240];
    std::snprintf(row, sizeof row, "%.15g,%.10g,%.10g,%.6f,%.6f,%.6f,%s,%.6f,%.6f,%.6f\n", series.time[n],
                  series.current[n], series.voltage[n], predicted.voltage[k], predicted.voltage_lower[k],
                  predicted.voltage_upper[k], predicted.voltage_drives[k] ? "voltage" : "current",
                  predicted.current[k], predicted.current_lower[k], predicted.current_upper[k]);
    text += row;
  }
  return text;
}

/// Whether the voltage drives where a source imposes it; gives the model a source when it was fitted without.
bool drivesBothWays(const PredictArguments& arguments, const Series& series, FittedModel& model) {
  if (arguments.drive == "current") return false;
  if (arguments.drive.empty()) return model.source.has_value();
  if (model.source) return true;
  const Source source = findSource(series);
  if (!source.seen)
    throw UsageError("--drive mixed: no source is seen in " + arguments.recording.path + ": " + source.summary);
  model.source = source.rule;
  return true;
}

int runPredict(const CommandLine& line, const PredictArguments& arguments) {
  FittedModel model = readModelFile(arguments.model);
  const Recording recording = loadRecording(arguments.recording);
  const Series series = atDesignRate(recording.series);
  const IndexRange range = rangeOf(arguments.window, series);
  const bool both_ways = drivesBothWays(arguments, series, model);
  const FollowedPrediction from_current = currentDriven(model, series, range);
  const FollowedPrediction predicted = both_ways ? predictMixed(model, series, range) : from_current;
  if (!arguments.csv.empty())
    writeFileAtomically(arguments.csv, predictionCsv(series, range, predicted));
  PredictionReport report;
  report.from_current = scorePrediction(
      series, range, {from_current.voltage, from_current.voltage_lower, from_current.voltage_upper});
  report.naive = scoreNaive(model.naive, series, range, predicted.voltage_drives);
  const PredictedVoltage line_voltage = naiveVoltage(model.naive, series, range);
  if (!line_voltage.voltage.empty())
    report.naive_from_current = scorePrediction(series, range, line_voltage);
  if (both_ways) {
    report.both_ways = scoreBothWays(model, series, range, predicted);
    report.from_current.cranks = report.both_ways->cranks;
    report.from_current.crank_mean_abs_error = report.both_ways->crank_mean_abs_error;
  }
  emit(line, predictionText(report), predictionJson(report), arguments.json);
  return kExitDone;
}

}  // namespace

void addPredictCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command =
      app.add_subcommand("predict", "run a model on a recording's current and score it");
  auto arguments = std::make_shared<PredictArguments>();
  command->add_option("MODEL", arguments->model, "model file of sof identify")->required();
  addRecordingOptions(*command, arguments->recording);
  addWindowOptions(*command, arguments->window);
  command->add_option("--csv", arguments->csv,
                      "write measured and predicted voltage and current sample by sample");
  command
      ->add_option("--drive", arguments->drive,
                   "mixed: by the voltage where a source imposes it; current: throughout. Default: as the model was fitted")
      ->check(CLI::IsMember({"mixed", "current"}));
  addJsonOption(*command, arguments->json);
  command->callback([&line, arguments] {
    line.run = [&line, arguments] { return runPredict(line, *arguments); };
  });
}

}  // namespace battery_sof
