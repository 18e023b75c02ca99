#include <filesystem>

#include "command.hpp"
#include "recording/checks.hpp"
#include "recording/series_blocks.hpp"
#include "report/results.hpp"
#include "util/text.hpp"

/// The commands that need no model: check, convert and effects.
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
  nlohmann::json json = checkReportJson(recording, report);
  json["series_blocks"] = series_blocks;
  const std::string row = series_blocks == 1.0 ? "" : seriesBlocksSentence(series_blocks) + "\n";
  progress.end();
  emit(line, row + checkReportText(recording, report), json, arguments.json);
  return kExitDone;
}

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

struct EffectsArguments {
  std::string id;
  bool markdown = false;
  std::string json;
};

int runEffects(const CommandLine& line, const EffectsArguments& arguments) {
  const bool all = arguments.id.empty();
  const std::vector<EffectInfo> effects =
      all ? effectsByTier() : std::vector<EffectInfo>{effectInfo(arguments.id)};
  std::string text = all ? catalogueText(effects) : effectText(effects.front());
  if (arguments.markdown) text = catalogueMarkdown(effects);
  emit(line, text, catalogueJson(effects), arguments.json);
  return kExitDone;
}

}  // namespace

void addCheckCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] = addSubcommand(
      app, line, "check",
      "lint a recording: rate, gaps, clipping, quantisation, sign, offset, skew, stuck values",
      runCheck);
  addRecordingOptions(options, values.recording);
  addSeriesBlocksOption(options, values.recording);
  addJsonOption(options, values.json);
}

void addConvertCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] =
      addSubcommand(app, line, "convert", "convert a recording between CSV and bag", runConvert);
  addFile(options, kReadFile, "IN", values.recording.path, kRecording)->required();
  addFile(options, kWrittenFile, "OUT", values.out, "file to write: .bag or .csv")->required();
  addRecordingOptions(options, values.recording, false);
  addJsonOption(options, values.json);
}

void addEffectsCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] = addSubcommand(
      app, line, "effects",
      "the physics that sof identify --effects can add: all of it, or one in full", runEffects);
  addOption(options, "ID", values.id, "an effect; without it a table of all");
  options.add_flag("--markdown", values.markdown, "print as docs/effects.md holds it");
  addJsonOption(options, values.json);
}

}  // namespace battery_sof
