#include "command.hpp"
#include "recording/checks.hpp"
#include "recording/series_blocks.hpp"
#include "report/check_report.hpp"

namespace battery_sof {
namespace {

struct CheckArguments {
  RecordingArguments recording;
  std::string json;
};

int runCheck(const CommandLine& line, const CheckArguments& arguments) {
  Progress progress(line.err);
  const Recording recording = loadRecording(arguments.recording);
  progress.stage("checking");
  const CheckReport report = checkRecording(recording);
  const double series_blocks = arguments.recording.series_blocks;
  nlohmann::json json = checkReportJson(recording.name, recording, report);
  json["series_blocks"] = series_blocks;
  const std::string row = series_blocks == 1.0 ? "" : seriesBlocksSentence(series_blocks) + "\n";
  progress.end();
  emit(line, row + checkReportText(recording.name, recording, report), json, arguments.json);
  return kExitDone;
}

}  // namespace

void addCheckCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand(
      "check",
      "lint a recording: rate, gaps, clipping, quantisation, sign, offset, skew, stuck values");
  auto arguments = std::make_shared<CheckArguments>();
  addRecordingOptions(*command, arguments->recording);
  addSeriesBlocksOption(*command, arguments->recording);
  addJsonOption(*command, arguments->json);
  whenChosen(*command, line, arguments, runCheck);
}

}  // namespace battery_sof
