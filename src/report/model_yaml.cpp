#include "report/model_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <string_view>

#include "model_parts.hpp"
#include "recording/series_blocks.hpp"
#include "util/atomic_file.hpp"
#include "util/constants.hpp"
#include "util/regular_file.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kLargestFile = 1 << 20;  // twenty times a model with every part
constexpr Range kDurations{0.0, 1e10};         // [s]
constexpr Range kCharges{0.0, 1e6};            // [Ah]
constexpr Range kErrors{0.0, 1e4};             // [V], [A]

FitStatus statusOf(const Reader& fit) {
  const std::string text = fit.text("status");
  for (FitStatus status : {FitStatus::kConverged, FitStatus::kIterationLimit, FitStatus::kStalled,
                           FitStatus::kWindowTooShort, FitStatus::kNotExcited})
    if (toString(status) == text) return status;
  fit.fail("status", "is \"" + text +
                         "\", expected converged, iteration_limit, stalled, "
                         "window_too_short or not_excited");
}

void readWindow(const Reader& root, Fit& fit) {
  const Reader window = root.at("window");
  fit.window = {window.number("from_s", kTimes), window.number("to_s", kTimes),
                window.whole<std::size_t>("samples")};
  if (fit.window.to < fit.window.from) window.fail("to_s", "is before from_s");
  auto& excited = fit.excited;
  excited.min_current = window.number("min_current_a", kCurrents);
  excited.max_current = window.number("max_current_a", kCurrents);
  excited.min_voltage = window.number("min_voltage_v", kVoltages);
  excited.max_voltage = window.number("max_voltage_v", kVoltages);
  excited.discharge_time = window.number("discharge_time_s", kDurations);
  excited.charge_time = window.number("charge_time_s", kDurations);
  if (window.has("longest_discharge_s"))
    excited.longest_discharge = window.number("longest_discharge_s", kDurations);
  if (window.has("longest_charge_s"))
    excited.longest_charge = window.number("longest_charge_s", kDurations);
  if (window.has("charge_swing_ah"))
    excited.charge_swing = window.number("charge_swing_ah", kCharges);
  if (window.has("temperature_c"))
    excited.temperature = window.number("temperature_c", {-kZeroCelsius, 1000.0}) + kZeroCelsius;
}

void readFit(const Reader& root, FittedModel& model) {
  const Reader fit = root.at("fit");
  model.fit.status = statusOf(fit);
  model.fit.message = fit.text("message");
  model.fit.start = fit.text("start");
  model.fit.iterations = fit.whole<int>("iterations");
  model.fit.scores.q_dyn_percent = fit.number("q_dyn_percent");
  model.fit.scores.rmse = fit.number("rmse_v", kErrors);
  if (fit.has("current_rmse_a"))
    model.fit.scores.current_rmse = fit.number("current_rmse_a", kErrors);
  if (fit.has("left_out_share_percent"))
    model.fit.scores.left_out_share_percent = fit.number("left_out_share_percent");
  model.fit.scores.crank_error_std = fit.number("crank_error_v", kErrors);
  model.fit.scores.cranks = fit.whole<int>("cranks");
  model.fit.scores.residual_correlation_time =
      fit.number("residual_correlation_time_s", kDurations);
  model.fit.window_quality = fit.number("window_quality", {0.0, 1.0});
  model.provenance.fit_ms = fit.number("fit_ms", {0.0, 1e12});
}

YAML::Node documentOf(const std::string& text, const std::string& source) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw ModelFileError(source + ": not YAML at line " + std::to_string(error.mark.line + 1) +
                         ", column " + std::to_string(error.mark.column + 1));
  }
}

double blocksOf(const Reader& root) {
  if (!root.has("series_blocks")) return 1.0;
  const double series_blocks = root.number("series_blocks");
  if (!areSeriesBlocks(series_blocks))
    root.fail("series_blocks", format("is %g, expected ", series_blocks) + kAllowedSeriesBlocks);
  return series_blocks;
}

FittedModel modelOf(const Reader& root) {
  const std::string schema = root.text("schema");
  if (schema == "battery_sof/model/1")
    root.fail("schema",
              "is of battery_sof 0.2, whose names are others; write the model again: sof identify "
              "REC --out MODEL.yaml");
  if (schema != kModelSchema)
    root.fail("schema", "is \"" + schema + "\", expected \"" + kModelSchema + "\"");
  FittedModel model;
  readEquations(root, model);
  readWindow(root, model.fit);
  readFit(root, model);
  readLessons(root, model);
  requireRuns(root, model);
  model.fit.series_blocks = blocksOf(root);
  model.provenance.recording = root.at("recording").text("name");
  model.provenance.recording_hash = root.at("recording").text("hash");
  return model;
}

}  // namespace

FittedModel parseModelYaml(const std::string& text, const std::string& source) {
  const YAML::Node document = documentOf(text, source);
  if (!document.IsMap()) throw ModelFileError(source + ": not a model: expected a YAML map");
  try {
    return modelOf(Reader(document, source, ""));
  } catch (const YAML::Exception& error) {
    throw ModelFileError(source + ": line " + std::to_string(error.mark.line + 1) +
                         " cannot be understood");
  }
}

void writeModelFile(const std::filesystem::path& path, const FittedModel& model) {
  writeFileAtomically(path, modelYaml(model));
}

FittedModel readModelFile(const std::filesystem::path& path) {
  std::string text;
  try {
    text = readRegularFile(path, kLargestFile);
  } catch (const std::runtime_error& error) {
    throw ModelFileError(error.what());
  }
  return parseModelYaml(text, path.string());
}

}  // namespace battery_sof
