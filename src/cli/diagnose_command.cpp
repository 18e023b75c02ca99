#include <filesystem>
#include <new>
#include <utility>

#include "api/identified.hpp"
#include "command.hpp"
#include "diagnosis/change.hpp"
#include "diagnosis/diagnose.hpp"
#include "diagnosis/response_table.hpp"
#include "report/change_page.hpp"
#include "report/change_results.hpp"
#include "report/diagnosis_page.hpp"
#include "report/model_yaml.hpp"
#include "report/results.hpp"
#include "util/files.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

struct DiagnoseArguments {
  RecordingArguments recording;  ///< each of the paths in turn
  std::vector<std::string> paths, references;
  WindowArguments window;
  PriorsArguments priors;
  std::string report, out, base_out, json;
  DiagnoseOptions options;
  bool responses_only = false;  ///< with references
};

/// The stretch that is diagnosed, at the rate the models are fitted at.
struct Stretch {
  Recording recording;
  std::string hash;
};

Stretch stretchOf(const RecordingArguments& file, const WindowArguments& window) {
  Stretch stretch;
  stretch.recording = loadRecording(file, &stretch.hash);
  Series& series = stretch.recording.series;
  series = atDesignRate(series);
  if (!series.empty()) series = slice(series, rangeOf(window, series));
  return stretch;
}

/// All of them before the minutes of work. What is wrong with one of several has its name.
std::vector<Stretch> stretchesOf(const DiagnoseArguments& arguments) {
  std::vector<Stretch> all;
  RecordingArguments file = arguments.recording;
  for (const std::string& path : arguments.paths) {
    file.path = path;
    try {
      all.push_back(stretchOf(file, arguments.window));
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      const bool has_name = std::string(error.what()).find(path) != std::string::npos;
      if (arguments.paths.size() == 1 || has_name) throw;
      throw UsageError(path + ": " + error.what());
    }
    for (std::size_t k = 0; k + 1 < all.size(); ++k)
      if (all[k].hash == all.back().hash)
        throw UsageError(path + " is the same recording as " + arguments.paths[k]);
  }
  return all;
}

/// A page that could not be written is found out before the minutes of work, not after.
void requireFolders(const DiagnoseArguments& arguments) {
  for (const std::string& file :
       {arguments.report, arguments.out, arguments.base_out, arguments.json}) {
    if (file.empty() || file == "-") continue;
    const auto folder = std::filesystem::absolute(file).parent_path();
    if (!std::filesystem::is_directory(folder))
      throw UsageError("cannot write " + file + ": there is no folder " + folder.string());
  }
}

void writeFiles(const DiagnoseArguments& arguments, const Recording& recording,
                const Diagnosis& diagnosis) {
  if (!arguments.report.empty())
    writeFileAtomically(arguments.report, diagnosisPage(recording, diagnosis));
  if (diagnosis.verdict == Verdict::kInsufficientData) return;
  if (!arguments.out.empty()) writeModelFile(arguments.out, diagnosis.extended);
  if (!arguments.base_out.empty()) writeModelFile(arguments.base_out, diagnosis.base);
}

/// Recordings at the rate models are fitted at, and their names.
struct Recordings {
  std::vector<Series> series;
  std::vector<std::string> names;
};

Recordings recordingsOf(const std::vector<Stretch>& stretches) {
  Recordings all;
  for (const Stretch& stretch : stretches) {
    all.series.push_back(stretch.recording.series);
    all.names.push_back(stretch.recording.name);
  }
  return all;
}

bool isModelFile(const std::string& path) {
  const auto ending = std::filesystem::path(path).extension();
  return ending == ".yaml" || ending == ".yml";
}

/// What --reference names: the recordings as a whole (--from and --to are of the recordings that
/// are diagnosed), and model files.
struct References {
  ChangeReference reference;
  std::vector<std::string> names;
};

void writeChange(const DiagnoseArguments& arguments, const std::vector<Stretch>& stretches,
                 ChangeDiagnosis& found, const ComparedSide& then, const ComparedSide& now) {
  if (!arguments.report.empty())
    writeFileAtomically(arguments.report, changePage(found, then, now));
  if (arguments.out.empty() || !found.model) return;
  FittedModel& model = *found.model;
  const Stretch& of = stretches[found.modelled];
  model.provenance.recording = of.recording.name;
  model.provenance.recording_hash = of.hash;
  model.fit.series_blocks = arguments.recording.series_blocks;
  model.responses = responseTable(of.recording.series, arguments.options.anyway);
  writeModelFile(arguments.out, model);
}

void requireNotOneOf(const std::vector<Stretch>& stretches, const DiagnoseArguments& arguments,
                     const std::string& hash, const std::string& path, const char* what) {
  for (std::size_t k = 0; k < stretches.size(); ++k)
    if (stretches[k].hash == hash)
      throw UsageError("--reference: " + path + what + arguments.paths[k]);
}

FittedModel referenceModel(const std::string& path, double series_blocks) {
  FittedModel model = readModelFile(path);
  if (model.fit.series_blocks != series_blocks)
    throw UsageError(
        format("--reference: %s is a model of %g blocks in series, but the recording is read as "
               "one of %g (--series-blocks)",
               path.c_str(), model.fit.series_blocks, series_blocks));
  return model;
}

References referencesOf(const DiagnoseArguments& arguments, const std::vector<Stretch>& stretches) {
  References all;
  DiagnoseArguments recordings = arguments;
  recordings.paths.clear();
  recordings.window = {};
  for (const std::string& path : arguments.references) {
    if (!isModelFile(path)) {
      recordings.paths.push_back(path);
      continue;
    }
    all.reference.models.push_back(referenceModel(path, arguments.recording.series_blocks));
    all.names.push_back(std::filesystem::path(path).filename().string());
    requireNotOneOf(stretches, arguments, all.reference.models.back().provenance.recording_hash,
                    path, " is a model of the same recording as ");
  }
  const std::vector<Stretch> read = stretchesOf(recordings);
  for (std::size_t k = 0; k < read.size(); ++k)
    requireNotOneOf(stretches, arguments, read[k].hash, recordings.paths[k],
                    " is the same recording as ");
  const Recordings found = recordingsOf(read);
  all.reference.recordings = found.series;
  all.names.insert(all.names.end(), found.names.begin(), found.names.end());
  return all;
}

int runChange(const CommandLine& line, const DiagnoseArguments& arguments) {
  Progress progress(line.err);
  const std::vector<Stretch> stretches = stretchesOf(arguments);
  const References then = referencesOf(arguments, stretches);
  ChangeOptions options;
  options.anyway = arguments.options.anyway;
  options.runs_models = !arguments.responses_only;
  options.progress = [&](const std::string& stage) { progress.stage(stage); };
  const Interruption interruption(progress);
  const Recordings now = recordingsOf(stretches);
  ChangeDiagnosis found = diagnoseChange(now.series, then.reference, options);
  progress.stage("writing");
  writeChange(arguments, stretches, found, {then.names, then.reference.recordings},
              {now.names, now.series});
  progress.end();
  emit(line, resultText(found), resultJson(found, now.names, then.names), arguments.json);
  if (found.verdict != ChangeVerdict::kInsufficientData) return kExitDone;
  complain(line.err, found.summary);
  return kExitNegative;
}

int runDiagnose(const CommandLine& line, const DiagnoseArguments& arguments) {
  requireFolders(arguments);
  if (!arguments.references.empty()) return runChange(line, arguments);
  if (arguments.paths.size() != 1)
    throw UsageError(format(
        "%zu recordings are given, expected one; several can only be compared with a --reference",
        arguments.paths.size()));
  DiagnoseOptions options = arguments.options;
  requireCapacity(options.capacity);
  options.priors = loadPriors(arguments.priors);
  options.crank_current = arguments.recording.crank_current;
  Progress progress(line.err);
  const Stretch stretch = stretchesOf(arguments).front();
  const Recording& recording = stretch.recording;
  options.progress = [&](const std::string& stage) { progress.stage(stage); };
  const Interruption interruption(progress);
  Diagnosis found = diagnose(recording, options);
  nameOrigin(found, recording, stretch.hash, arguments.recording.series_blocks);
  progress.stage("writing");
  writeFiles(arguments, recording, found);
  progress.end();
  emit(line, resultText(found), resultJson(found), arguments.json);
  if (found.verdict != Verdict::kInsufficientData) return kExitDone;
  complain(line.err, found.summary);
  return kExitNegative;
}

}  // namespace

void addDiagnoseCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] = addSubcommand(
      app, line, "diagnose",
      "find where the circuit deviates from a recording, and which physics is missing",
      runDiagnose);
  DiagnoseOptions& search = values.options;
  addFile(options, kReadFile, "REC", values.paths,
          std::string(kRecordingFile) + "; with --reference, several of one battery")
      ->required();
  addRecordingOptions(options, values.recording, false);
  addSeriesBlocksOption(options, values.recording);
  addCrankCurrentOption(options, values.recording);
  addWindowOptions(options, values.window);
  CLI::Option* reference =
      addFile(options, kReadFile, "--reference", values.references,
              "recording of the same battery from when it was sound, or the MODEL.yaml of one: "
              "reports what has changed since (docs/changes.md); repeatable")
          ->allow_extra_args(false);
  CLI::Option* responses_only =
      options
          .add_flag(
              "--responses-only", values.responses_only,
              "compare without fitting models: takes a second, but does not notice another battery")
          ->needs(reference);
  addFile(options, kWrittenFile, "--report", values.report,
          "page to write: one HTML file that needs no network");
  addFile(options, kWrittenFile, "--out", values.out,
          "model file to write: the base model with what was found; with --reference, the model "
          "that is fitted to REC")
      ->excludes(responses_only);
  addFile(options, kWrittenFile, "--base-out", values.base_out,
          "model file to write: the base model alone")
      ->excludes(reference);
  addOption(options, "--holdout", search.holdout_share,
            "share of the samples, at the end, that is kept for the comparison");
  CLI::Option* hypotheses =
      addEffectIds(options, "--hypotheses", search.hypotheses,
                   "ids of the effects to test, comma-separated; by default all that sof effects "
                   "lists, fresh_sulphate only where a source controls the voltage");
  addEffectIds(options, "--given", search.given,
               "ids of effects that are known to be present, comma-separated: they are modelled, "
               "and no others are searched for")
      ->excludes(hypotheses)
      ->excludes(reference);
  hypotheses->excludes(reference);
  addOption(
      options, "--capacity-ah", search.capacity,
      "nominal capacity [Ah]: where a tenth of it was moved (of 50 if it is not given), the "
      "open-circuit voltage moves as well, so ocv_soc is preferred among effects that explain the "
      "recording equally well")
      ->excludes(reference);
  addOption(options, "--min-rmse", search.relevance.rmse,
            "smallest RMS effect that is reported [V]; half the noise if that is larger");
  addOption(options, "--min-crank", search.relevance.crank,
            "smallest mean effect on cranks that is reported [V]");
  addOption(options, "--min-charge", search.relevance.charge_share,
            "smallest share of the charging current that is reported where a charger controls the "
            "voltage");
  addRenamedOption(options, "--confirm", "gone");
  for (const std::string limit : {"rmse", "crank", "charge"})
    addRenamedOption(options, "--relevance-" + limit, "--min-" + limit);
  addAnywayOption(options, search.anyway);
  addPriorsOptions(options, values.priors);
  addOption(options, "--threads", search.threads,
            "number of threads, 0: all cores; does not change the result");
  addJsonOption(options, values.json);
}

}  // namespace battery_sof
