#include <filesystem>
#include <ostream>

#include "command.hpp"
#include "util/printable.hpp"

namespace battery_sof {
namespace {

struct ConvertArguments {
  RecordingArguments recording;
  std::string out;
  std::string json;
};

int runConvert(const CommandLine& line, const ConvertArguments& arguments) {
  const std::string extension = std::filesystem::path(arguments.out).extension();
  if (extension != ".bag" && extension != ".csv")
    throw UsageError(arguments.out + ": expected a name ending in .bag or .csv");
  Progress progress(line.err);
  const Recording recording = loadRecording(arguments.recording);
  progress.stage("writing");
  if (extension == ".bag")
    writeBag(arguments.out, recording.series, arguments.recording.topic);
  else
    writeCsv(arguments.out, recording.series);
  progress.end();
  const std::size_t samples = recording.series.size();
  const std::size_t rejected = recording.rejected.total();
  emit(line,
       std::to_string(samples) + " samples written to " + printable(arguments.out) + ", " +
           std::to_string(rejected) + " rejected (sof check says why)\n",
       {{"schema", "battery_sof/conversion/1"},
        {"out", printable(arguments.out)},
        {"samples", samples},
        {"rejected", rejected}},
       arguments.json);
  return kExitDone;
}

}  // namespace

void addConvertCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("convert", "convert a recording between CSV and bag");
  auto arguments = std::make_shared<ConvertArguments>();
  command->add_option("IN", arguments->recording.path, "recording: .bag, .csv, or CSV from a pipe")
      ->required()
      ->type_name(kReadFile);
  command->add_option("OUT", arguments->out, "file to write: .bag or .csv")
      ->required()
      ->type_name(kWrittenFile);
  addRecordingOptions(*command, arguments->recording, false);
  addJsonOption(*command, arguments->json);
  whenChosen(*command, line, arguments, runConvert);
}

}  // namespace battery_sof
