#include "api/identified.hpp"
#include "command.hpp"
#include "prediction/pipeline.hpp"
#include "recording/checks.hpp"
#include "recording/control_mode.hpp"
#include "recording/events.hpp"
#include "report/model_yaml.hpp"
#include "report/results.hpp"
#include "state/posterior.hpp"

namespace battery_sof {
namespace {

constexpr const char* kUnlessAnyway = "; with --anyway it is fitted as it is";

struct IdentifyArguments {
  RecordingArguments recording;
  WindowArguments window;
  bool automatic = false, anyway = false;
  std::string out, json;
  std::string start = "robust";
  PriorsArguments priors;
  IdentifyOptions options;
};

/// Prints the findings except notes, and except problems that a refusal will repeat.
void warn(const CommandLine& line, Progress& progress, const Recording& recording,
          const Series& series, const IdentifyArguments& arguments) {
  const CheckReport report = checkRecording(recording, arguments.recording.crank_current);
  const std::string refusal = arguments.anyway ? "" : format(findProblems(series));
  progress.hide();
  for (const Finding& finding : report.findings)
    if (finding.severity != Severity::kNote && refusal.find(finding.what) == std::string::npos)
      line.err << "warning: " << finding.what << ": " << finding.meaning << "\n";
}

/// The effect "none" names the base model. @throws UsageError for effects that cannot be composed.
IdentifyOptions optionsOf(const IdentifyArguments& arguments) {
  requireCapacity(arguments.options.capacity);
  IdentifyOptions options = arguments.options;
  options.start = arguments.start == "paper" ? FitStart::kPaper : FitStart::kRobust;
  options.chooses_effects = options.effects.empty();
  if (options.effects == std::vector<std::string>{"none"}) options.effects.clear();
  try {
    BatteryModel composed(options.effects);
  } catch (const std::invalid_argument& error) {
    throw UsageError(std::string("--effects: ") + error.what());
  }
  return options;
}

int runIdentify(const CommandLine& line, const IdentifyArguments& arguments) {
  FitRequest request;
  request.options = optionsOf(arguments);
  request.chooses_window = arguments.automatic;
  request.anyway = arguments.anyway;
  request.crank_current = arguments.recording.crank_current;
  Progress progress(line.err);
  std::string hash;
  const Recording recording = loadRecording(arguments.recording, &hash);
  progress.stage("checking");
  const Series series = atDesignRate(recording.series);
  warn(line, progress, recording, series, arguments);
  progress.stage("identifying");
  request.from = parseTime(arguments.window.from, series, "--from");
  request.to = parseTime(arguments.window.to, series, "--to");
  request.options.priors = loadPriors(arguments.priors);
  FittedModel model = identified(series, request);
  nameOrigin(model, recording, hash, arguments.recording.series_blocks);
  const auto& priors = request.options.priors;
  if (!priors.empty() && knownOf(priors, model.fit.effects).empty())
    line.err
        << "warning: " << arguments.priors.file
        << " has no parameters for the effects of this model: the catalogue's priors are used\n";
  progress.end();
  const bool is_usable = isUsable(model.fit);
  if (is_usable) writeModelFile(arguments.out, model);
  const ControlModes mode = detectControlMode(series, EventLimits{model.fit.crank_current});
  nlohmann::json json = resultJson(model);
  json["operating_mode"] = {{"seen", mode.seen}, {"share", mode.share}, {"summary", mode.summary}};
  emit(line, resultText(model, mode), json, arguments.json);
  const Reasons why_none = is_usable ? whyNoCrank(model) : Reasons();
  if (!why_none.empty())
    line.err
        << "warning: this model gives no valid answer on a crank or a stop: "
        << toString(why_none, model.fit.series_blocks)
        << (detectCranks(series, {0, series.size()}, EventLimits{model.fit.crank_current}).empty()
                ? "; the recording has no engine start\n"
                : "; choose a window with engine starts (sof check has their times)\n");
  if (is_usable) return kExitDone;
  const bool is_refused = model.fit.status == FitStatus::kRefused;
  complain(line.err, "no model: " + model.fit.message + (is_refused ? kUnlessAnyway : ""));
  return kExitNegative;
}

}  // namespace

void addIdentifyCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] =
      addSubcommand(app, line, "identify", "fit the model to a window of a recording", runIdentify);
  IdentifyOptions& fit = values.options;
  addRecordingOptions(options, values.recording);
  addSeriesBlocksOption(options, values.recording);
  addCrankCurrentOption(options, values.recording);
  addWindowOptions(options, values.window);
  options.add_flag("--auto", values.automatic,
                   "choose the window inside --from and --to even when both are given");
  addFile(options, kWrittenFile, "--out", values.out, "model file to write")->required();
  addEffectIds(
      options, "--effects", fit.effects,
      "effects to add to the circuit: comma-separated ids, which sof effects lists, or none. "
      "Default: fresh_sulphate where a charger controls the voltage for a minute or more while it "
      "charges, else none. Where a tenth of the capacity was moved: ocv_soc, with end_of_discharge "
      "if as much was discharged and "
      "acceptance_soc if as much was charged by a charger that controlled the voltage; the same "
      "with resistance_soc, or the default of less charge if it went there and back more than "
      "once, where that predicts left-out parts of the window better");
  addOption(
      options, "--capacity-ah", fit.capacity,
      "nominal capacity [Ah]: the default of --effects depends on it (50 if it is not given), "
      "and where a discharge ends is fitted with what is known of it");
  addOption(options, "--threads", fit.threads,
            "threads of a fit with effects, 0: all cores; does not change the result");
  addOption(options, "--start", values.start, "initial state: estimated, or as in the paper")
      ->check(CLI::IsMember({"robust", "paper"}));
  addOption(options, "--crank-weight", fit.crank_weight,
            "weight W of discharges beyond --crank-current [1], at least 1; without effect where "
            "samples are 0.25 s or more apart, but for --start paper");
  addRenamedOption(options, "--crank-weight-current", "--crank-current");
  addOption(options, "--max-iterations", fit.max_iterations,
            "largest number of iterations; a short window may take 25 times as many from 20 on");
  addAnywayOption(options, values.anyway);
  addPriorsOptions(options, values.priors);
  addJsonOption(options, values.json);
}

}  // namespace battery_sof
