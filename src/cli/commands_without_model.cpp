#include <filesystem>

#include "can_log.hpp"
#include "command.hpp"
#include "recording/channel_shift.hpp"
#include "recording/checks.hpp"
#include "recording/crank_current.hpp"
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
  std::vector<std::string> notes;
  const Recording recording = loadRecording(arguments.recording, nullptr, &notes);
  progress.stage("checking");
  const CheckReport report = checkRecording(recording, arguments.recording.crank_current);
  const double series_blocks = arguments.recording.series_blocks;
  nlohmann::json json = checkReportJson(recording, report);
  json["series_blocks"] = series_blocks;
  json["assumed"] = notes;
  const std::string row = series_blocks == 1.0 ? "" : seriesBlocksSentence(series_blocks) + "\n";
  progress.end();
  std::string text = row + checkReportText(recording, report);
  if (!notes.empty()) text += "\n  assumed of the file\n";
  for (const std::string& note : notes) text += "    " + note + "\n";
  emit(line, text, json, arguments.json);
  return kExitDone;
}

struct ConvertArguments {
  RecordingArguments recording;
  std::string dbc;             // file that says where the signals of a CAN log are
  double shift_current = 0.0;  // [s]
  std::string out;
  std::string json;
};

/// @throws UsageError where nothing is left.
Series shifted(const Series& series, double shift) {
  if (shift == 0.0) return series;
  Series moved = withShiftedCurrent(series, shift);
  if (moved.empty())
    throw UsageError(
        format("--shift-current %g leaves no sample, expected less than the recording's "
               "%g s",
               shift, series.time.back() - series.time.front()));
  return moved;
}

/// The recording, or that of a CAN log, whose signals the options for the columns name.
Recording loadInput(const ConvertArguments& arguments) {
  if (arguments.dbc.empty()) return loadRecording(arguments.recording);
  const CsvColumns& columns = arguments.recording.columns;
  const CsvColumns own;
  if (columns.current == own.current || columns.voltage == own.voltage)
    throw UsageError(
        "--dbc is given, expected --current-column and --voltage-column too: the names of the "
        "signals in the DBC file");
  const CanLogAsCsv csv(arguments.recording.path,
                        {arguments.dbc, columns.current, columns.voltage, columns.temperature,
                         columns.discharge_positive});
  RecordingArguments recording = arguments.recording;
  recording.path = csv.path();
  recording.columns = own;
  recording.time_unit = "s";
  return loadRecording(recording);
}

int runConvert(const CommandLine& line, const ConvertArguments& arguments) {
  const std::string extension = std::filesystem::path(arguments.out).extension();
  if (extension != ".bag" && extension != ".csv")
    throw UsageError(arguments.out + ": expected a name ending in .bag or .csv");
  Progress progress(line.err);
  const Recording recording = loadInput(arguments);
  const Series series = shifted(recording.series, arguments.shift_current);
  progress.stage("writing");
  if (extension == ".bag")
    writeBag(arguments.out, series, arguments.recording.topic);
  else
    writeCsv(arguments.out, series);
  progress.end();
  const std::size_t samples = series.size(), without = recording.series.size() - samples;
  const std::size_t rejected = recording.rejected.total();
  std::string text = std::to_string(samples) + " samples written to " + printable(arguments.out) +
                     ", " + std::to_string(rejected) +
                     (rejected > 0 ? " rejected (sof check says why)\n" : " rejected\n");
  if (arguments.shift_current != 0.0)
    text += format(
        "the current was shifted by %g s; %zu samples were left out, because the shift leaves them "
        "without a current\n",
        arguments.shift_current, without);
  const CrankCurrent crank = crankCurrentOf(series, arguments.recording.crank_current);
  const std::size_t cranks =
      detectCranks(series, {0, series.size()}, EventLimits{crank.current}).size();
  if (arguments.recording.crank_current)
    text += format("the recording has %zu engine %s of %g A or below\n", cranks,
                   cranks == 1 ? "start" : "starts", crank.current);
  emit(line, text,
       {{"schema", "battery_sof/conversion/1"},
        {"crank_current_a", crank.current},
        {"cranks", cranks},
        {"out", printable(arguments.out)},
        {"samples", samples},
        {"rejected", rejected},
        {"shift_current_s", arguments.shift_current},
        {"left_out", without}},
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
  addCrankCurrentOption(options, values.recording);
  addJsonOption(options, values.json);
}

void addConvertCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] =
      addSubcommand(app, line, "convert",
                    "convert a recording between CSV and bag, or a log of a CAN bus", runConvert);
  addFile(options, kReadFile, "IN", values.recording.path,
          std::string(kRecordingFile) + "; with --dbc a CAN log: .blf, .asc, .mf4")
      ->required();
  addFile(options, kWrittenFile, "OUT", values.out, "file to write: .bag or .csv")->required();
  addRecordingOptions(options, values.recording, false);
  addCrankCurrentOption(options, values.recording);
  addFile(options, kReadFile, "--dbc", values.dbc,
          "DBC file of a CAN log, whose signals --current-column, --voltage-column and "
          "--temperature-column name (MESSAGE.SIGNAL where a name is in two messages). Needs "
          "python3-can; .mf4 also needs asammdf, which Debian 12 does not have");
  addOption(options, "--shift-current", values.shift_current,
            "shift the current against the voltage by this time [s]: above 0 if the voltage comes "
            "late, below 0 if the current does. sof check and sof diagnose report by how much");
  addJsonOption(options, values.json);
}

void addEffectsCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] = addSubcommand(
      app, line, "effects", "list the effects that sof identify --effects can add, or describe one",
      runEffects);
  addOption(options, "ID", values.id,
            "id of an effect; if it is not given, a table of all effects is printed");
  options.add_flag("--markdown", values.markdown, "print in the format of docs/effects.md");
  addJsonOption(options, values.json);
}

}  // namespace battery_sof
