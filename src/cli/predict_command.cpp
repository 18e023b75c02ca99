#include <cstdio>

#include "battery_sof/predict/profile.hpp"
#include "battery_sof/predict/scores.hpp"
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
  std::string csv, json;
};

std::string predictionCsv(const Series& series, IndexRange range,
                          const PredictedVoltage& predicted) {
  std::string text = "time_s,current_a,voltage_v,predicted_v,lower_v,upper_v\n";
  for (std::size_t n = range.first; n < range.last; ++n) {
    const std::size_t k = n - range.first;
    char row[160];
    std::snprintf(row, sizeof row, "%.15g,%.10g,%.10g,%.6f,%.6f,%.6f\n", series.time[n],
                  series.current[n], series.voltage[n], predicted.voltage[k], predicted.lower[k],
                  predicted.upper[k]);
    text += row;
  }
  return text;
}

int runPredict(const CommandLine& line, const PredictArguments& arguments) {
  const FittedModel model = readModelFile(arguments.model);
  const Recording recording = loadRecording(arguments.recording);
  const Series series = atDesignRate(recording.series);
  const IndexRange range = rangeOf(arguments.window, series);
  const PredictedVoltage predicted = predictSeries(model, series, range);
  if (!arguments.csv.empty())
    writeFileAtomically(arguments.csv, predictionCsv(series, range, predicted));
  const PredictionScores scores = scorePrediction(series, range, predicted);
  emit(line, predictionText(scores), predictionJson(scores), arguments.json);
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
                      "write measured and predicted voltage sample by sample");
  addJsonOption(*command, arguments->json);
  command->callback([&line, arguments] {
    line.run = [&line, arguments] { return runPredict(line, *arguments); };
  });
}

}  // namespace battery_sof
