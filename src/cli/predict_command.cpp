
#include "command.hpp"
#include "prediction/scores.hpp"
#include "report/model_yaml.hpp"
#include "report/results.hpp"
#include "util/files.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

struct PredictArguments {
  std::string model;
  RecordingArguments recording;
  WindowArguments window;
  std::string csv, json, mode;
};

std::string predictionCsv(const Series& series, IndexRange range,
                          const FollowedPrediction& predicted) {
  std::string text =
      "time_s,current_a,voltage_v,predicted_v,lower_v,upper_v,driven_by,predicted_a,lower_a,upper_"
      "a\n";
  for (std::size_t n = range.first; n < range.last; ++n) {
    const std::size_t k = n - range.first;
    text += format("%.15g,%.10g,%.10g,%.6f,%.6f,%.6f,%s,%.6f,%.6f,%.6f\n", series.time[n],
                   series.current[n], series.voltage[n], predicted.voltage[k],
                   predicted.voltage_lower[k], predicted.voltage_upper[k],
                   predicted.voltage_controlled[k] ? "voltage" : "current", predicted.current[k],
                   predicted.current_lower[k], predicted.current_upper[k]);
  }
  return text;
}

RangePrediction predict(const PredictArguments& arguments, const Series& series, IndexRange range) {
  FittedModel model = readModelFile(arguments.model);
  if (const auto given = arguments.recording.crank_current) model.fit.crank_current = *given;
  const PredictionMode mode = arguments.mode.empty()      ? PredictionMode::kAsFitted
                              : arguments.mode == "mixed" ? PredictionMode::kMixed
                                                          : PredictionMode::kCurrent;
  try {
    return predictRange(model, series, range, mode);
  } catch (const NoSource& none) {
    throw UsageError(std::string("--mode mixed: ") + none.what() + " (" + arguments.recording.path +
                     ")");
  }
}

int runPredict(const CommandLine& line, const PredictArguments& arguments) {
  Progress progress(line.err);
  const Recording recording = loadRecording(arguments.recording);
  progress.stage("predicting");
  const Series series = atDesignRate(recording.series);
  const IndexRange range = rangeOf(arguments.window, series);
  const RangePrediction predicted = predict(arguments, series, range);
  if (!arguments.csv.empty())
    writeFileAtomically(arguments.csv, predictionCsv(series, range, predicted.course));
  progress.end();
  emit(line, resultText(predicted.report), resultJson(predicted.report), arguments.json);
  return kExitDone;
}

}  // namespace

void addPredictCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] = addSubcommand(
      app, line, "predict", "run a model on a recording's current and score it", runPredict);
  addModelOption(options, values.model);
  addRecordingOptions(options, values.recording);
  addCrankCurrentOption(options, values.recording);
  addWindowOptions(options, values.window);
  addFile(options, kWrittenFile, "--csv", values.csv,
          "write measured and predicted voltage and current sample by sample");
  addOption(options, "--mode", values.mode,
            "input of the model. mixed: the voltage where a charger controls it, else the current; "
            "current: the current throughout. Default: as the model was fitted")
      ->check(CLI::IsMember({"mixed", "current"}));
  addRenamedOption(options, "--drive", "--mode");
  addJsonOption(options, values.json);
}

}  // namespace battery_sof
