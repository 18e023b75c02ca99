#include "report/model_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <memory>

#include "battery_sof/version.hpp"
#include "error_fields.hpp"
#include "prediction/pipeline.hpp"
#include "recording/control_mode.hpp"
#include "recording/series_blocks.hpp"
#include "response_fields.hpp"
#include "state/state_estimator.hpp"
#include "util/constants.hpp"
#include "util/files.hpp"
#include "util/text.hpp"
#include "yaml_fields.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kLargestFile = 1 << 20;  // more than ten times a model with every part
constexpr Range kDurations{0.0, 1e10};         // [s]
constexpr Range kCharges{0.0, 1e6};            // [Ah]
constexpr Range kErrors{0.0, 1e4};             // [V], [A]
constexpr double kMinStep = 1e-3;              // [s], of a phase and a charge
constexpr std::size_t kMaxLag = 100;  // [samples], ten seconds of the slowest fast recording

// ---------------------------------------------------------------------------------------------
// The parts of a file, described for both directions (yaml_fields.hpp): Part is const when it is
// written.

/// Does what throws std::invalid_argument; that is the file's fault.
template <typename Work>
void orFail(const FieldReader& file, const char* key, const std::string& what, Work&& work) {
  std::string why;
  try {
    work();
  } catch (const std::invalid_argument& error) {
    why = error.what();
  }
  file.require(why.empty(), key, what + why);
}

/// Fits with a penalty go a little beyond the bounds, and bounds differ between versions: a decade,
/// or as much again.
Range rangeOf(const ParameterInfo& info) {
  if (info.instant) return kTimes;
  if (info.lower > 0.0) return {0.1 * info.lower, 10.0 * info.upper};
  const double span = info.upper - info.lower;
  return {info.lower - span, info.upper + span};
}

template <typename File, typename Estimate>
void describeEstimate(File& file, Estimate& estimate, const ParameterInfo& info) {
  file.number("value", estimate.value, rangeOf(info));
  file.number("std_error", estimate.std, {0.0, kMaxStd * (info.upper - info.lower)});
  file.text("unit", estimate.unit);
  if (file.has("held", estimate.held)) file.flag("held", estimate.held);
  file.flag("at_bound", estimate.at_bound);
  file.flag("determined", estimate.determined);
}

template <typename File, typename Model>
void describeParameters(File& file, Model& fit, const BatteryModel& composition) {
  if constexpr (File::kReads)
    for (const ParameterInfo& info : composition.parameters())
      fit.estimates.emplace_back().name = info.name;
  file.map("parameters", [&](auto& all) {
    for (std::size_t j = 0; j < fit.estimates.size(); ++j)
      all.map(
          fit.estimates[j].name,
          [&](auto& one) { describeEstimate(one, fit.estimates[j], composition.parameters()[j]); },
          MapStyle::kFlow);
    if constexpr (File::kReads) {
      Eigen::VectorXd values(composition.parameterCount());
      for (Eigen::Index j = 0; j < values.size(); ++j)
        values[j] = fit.estimates[static_cast<std::size_t>(j)].value;
      fit.parameters = baseParameters(values);
    }
  });
  file.map("fixed", [&](auto& fixed) {
    // Every simulation has these two: with others the file's model would be another.
    fixed.number("i0_a", fit.parameters.i0, {BaseParameters{}.i0, BaseParameters{}.i0});
    fixed.number("alpha", fit.parameters.alpha, {BaseParameters{}.alpha, BaseParameters{}.alpha});
  });
}

/// @param std standard errors of the states.
template <typename File, typename Model, typename Std>
void describeState(File& file, Model& model, Std& std, const BatteryModel& composition) {
  auto& state = model.state;
  file.number("time_s", state.time, kTimes);
  file.number("u_c2_v", state.states[0], kVoltages);
  file.number("u_c2_std_v", std[0], {0.0, kMaxStd});
  file.number("current_a", state.current, kCurrents);
  if constexpr (File::kReads)
    state.states.conservativeResizeLike(Eigen::VectorXd::Zero(composition.stateCount()));
  if (composition.stateCount() > 1)
    file.map("further", [&](auto& further) {
      for (Eigen::Index j = 1; j < composition.stateCount(); ++j)
        further.map(
            composition.states()[static_cast<std::size_t>(j)].name,
            [&](auto& one) {
              one.number("value", state.states[j], kNumbers);
              one.number("std_error", std[j], {0.0, kMaxStd});
              std::string unit = composition.states()[static_cast<std::size_t>(j)].unit;
              one.text("unit", unit);
            },
            MapStyle::kFlow);
    });
  if (file.has("memory", state.memory.begun)) {
    std::vector<double> numbers = state.memory.numbers();
    file.numbers("memory", numbers, InputMemory::kNumbers);
    if constexpr (File::kReads) state.memory = InputMemory::fromNumbers(numbers);
  }
  if (model.fit.discrepancy)
    file.numbers("regressor_memory", state.regressor_memory, model.fit.discrepancy->memorySize());
}

template <typename File, typename Model>
void describeWindow(File& file, Model& fit) {
  file.number("from_s", fit.window.from, kTimes);
  file.number("to_s", fit.window.to, kTimes);
  file.count("samples", fit.window.samples);
  file.require(fit.window.to >= fit.window.from, "to_s", "is before from_s");
  auto& excited = fit.excited;
  file.number("min_current_a", excited.min_current, kCurrents);
  file.number("max_current_a", excited.max_current, kCurrents);
  file.number("min_voltage_v", excited.min_voltage, kVoltages);
  file.number("max_voltage_v", excited.max_voltage, kVoltages);
  file.number("discharge_time_s", excited.discharge_time, kDurations);
  file.number("charge_time_s", excited.charge_time, kDurations);
  file.number("longest_discharge_s", excited.longest_discharge, kDurations);
  file.number("longest_charge_s", excited.longest_charge, kDurations);
  file.number("charge_swing_ah", excited.charge_swing, kCharges);
  file.number("sensor_min_current_a", excited.sensor_min_current, kCurrents);
  std::optional<double> crank_current = fit.crank_current;  // files of before have none
  file.number("crank_current_a", crank_current, {kCurrents.least, -1e-3});
  if constexpr (File::kReads) fit.crank_current = crank_current.value_or(kCrankCurrent);
  file.number("nominal_capacity_ah", fit.nominal_capacity, {1e-3, kCharges.most});
  std::optional<double> celsius;
  if (excited.temperature) celsius = *excited.temperature - kZeroCelsius;
  file.number("temperature_c", celsius, {-kZeroCelsius, 1000.0});
  if constexpr (File::kReads)
    if (celsius) excited.temperature = *celsius + kZeroCelsius;
}

template <typename File, typename Model>
void describeFit(File& file, Model& model) {
  constexpr FitStatus kAll[] = {FitStatus::kConverged,  FitStatus::kIterationLimit,
                                FitStatus::kStalled,    FitStatus::kWindowTooShort,
                                FitStatus::kNotExcited, FitStatus::kImplausible,
                                FitStatus::kRefused};
  auto& scores = model.fit.scores;
  file.oneOf("status", model.fit.status, kAll, [](FitStatus one) { return toString(one); });
  file.text("message", model.fit.message);
  file.text("start", model.fit.start);
  file.count("iterations", model.fit.iterations);
  file.number("q_dyn_percent", scores.q_dyn_percent);
  file.number("rmse_v", scores.rmse, kErrors);
  file.number("current_rmse_a", scores.current_rmse, kErrors);
  file.number("left_out_share_percent", scores.left_out_share_percent);
  file.number("crank_error_v", scores.crank_error_std, kErrors);
  file.count("cranks", scores.cranks);
  file.number("residual_correlation_time_s", scores.residual_correlation_time, kDurations);
  file.number("window_quality", model.fit.window_quality, {0.0, 1.0});
  file.number("fit_ms", model.provenance.fit_ms, {0.0, 1e12});
}

template <typename File, typename Errors>
void requireRising(File& file, const char* key, const Errors& errors) {
  file.require(errors.error.lower <= errors.error.upper, key,
               "has a lower error above the upper one");
}

template <typename File, typename Baseline>
void describeBaseline(File& file, Baseline& baseline) {
  const auto line = [](auto& to, const char* key, auto& l) {
    to.row(key, l.intercept, l.slope, l.std, l.error.lower, l.error.upper, l.centre, l.spread,
           l.samples);
    requireRising(to, key, l);
    to.require(l.std >= 0.0 && l.spread >= 0.0, key, "has a deviation or spread below 0");
  };
  const auto history = [](auto& to, const char* key, auto& h) {
    to.row(key, h.median, h.last, h.error.lower, h.error.upper, h.events);
    requireRising(to, key, h);
  };
  file.part("current_from_voltage", baseline.current_from_voltage, line);
  file.part("voltage_from_current", baseline.voltage_from_current, line);
  file.part("phase", baseline.phase, [](auto& to, const char* key, auto& p) {
    to.map(key, [&](auto& phase) {
      phase.numbers("current_a", p.current, 0, kCurrents);
      phase.number("step_s", p.step, kTimes);
      phase.row("errors", p.std, p.error.lower, p.error.upper, p.charges);
      requireRising(phase, "errors", p);
      phase.require(!p.current.empty() && p.step >= kMinStep, "current_a",
                    "must not be empty, step_s above 0");
    });
  });
  file.part("cranks", baseline.cranks, [](auto& to, const char* key, auto& c) {
    to.row(key, c.last.current, c.last.minimum, c.median.current, c.median.minimum, c.intercept,
           c.slope, c.error.lower, c.error.upper, c.events);
    requireRising(to, key, c);
  });
  file.part("charge_10s", baseline.charge_10s, history);
  file.part("charge_60s", baseline.charge_60s, history);
}

template <typename File, typename Model>
void describeSource(File& file, Model& fit) {
  constexpr ControlMode kModes[] = {ControlMode::kVoltage, ControlMode::kCurrent};
  auto& rule = *fit.source;
  file.number("min_current_a", rule.min_current, kCurrents);
  file.oneOf("charge_begins", rule.charge_begins, kModes,
             [](ControlMode one) { return toString(one); });
  file.number("current_noise_a", rule.current_noise, kCurrents);
  file.number("voltage_noise_v", rule.voltage_noise, kVoltages);
  file.number("resistance_ohm", rule.resistance, {-1e3, 1e3});
  file.number("max_gap_s", rule.max_gap, kTimes);
  if constexpr (File::kReads) {
    rule.present = true;
    orFail(file, "min_current_a",
           "and its neighbours cannot be used: ", [&] { ControlModeDetector sound(rule); });
  }
  file.count("voltage_lag_samples", fit.voltage_lag, kMaxLag);
}

template <typename File, typename History>
void describeEvents(File& file, History& history) {
  file.rows("cranks", history.cranks, {kTimes, kCurrents, kVoltages, kVoltages},
            [](auto& c, auto&& take) { take(c.time, c.current, c.measured, c.modelled); });
  file.rows("charges", history.charges,
            {kTimes, {kMinStep, kTimes.most}, kVoltages, kVoltages, kCurrents, kCurrents},
            [](auto& c, auto&& take) {
              take(c.time, c.duration, c.voltage, c.first_voltage, c.measured, c.modelled);
            });
  file.rows("stops", history.stops, {kTimes, kCurrents, kVoltages, kVoltages},
            [](auto& s, auto&& take) { take(s.time, s.current, s.measured, s.modelled); });
  if constexpr (File::kReads) {
    for (PastEvent& charge : history.charges) charge.kind = PastEvent::Kind::kCharge;
    for (PastEvent& stop : history.stops) stop.kind = PastEvent::Kind::kStop;
    for (PastEvent& stop : history.stops) stop.duration = PastEvent::kStopAge;
    EventHistory newest;
    for (const auto* past : {&history.cranks, &history.charges, &history.stops})
      for (const PastEvent& event : *past) newest.add(event);
    history = newest;
  }
}

/// @param columns how many it is a regression on.
template <typename File, typename Ridge>
void describeRidge(File& file, Ridge& fit, Eigen::Index columns) {
  file.numbers("centre", fit.centre);
  file.numbers("scale", fit.scale);
  file.numbers("weight", fit.weight);
  file.numbers("lower", fit.lower);
  file.numbers("upper", fit.upper);
  file.number("constant", fit.constant, kNumbers);
  file.number("penalty", fit.penalty);
  file.number("gain", fit.gain);
  const Eigen::Index size = fit.weight.size(), bounds = fit.lower.size();
  file.require(fit.centre.size() == size && fit.scale.size() == size &&
                   fit.upper.size() == bounds && (bounds == 0 || bounds == size) &&
                   (fit.scale.array() > 0.0).all(),
               "weight", "and its neighbours must be as many finite numbers, scales above 0");
  file.require((fit.lower.array() <= fit.upper.array()).all(), "lower", "must not be above upper");
  file.require(size == columns, "weight",
               "has " + std::to_string(size) + " numbers, expected " + std::to_string(columns));
}

template <typename File, typename Regression>
void describeRegression(File& file, Regression& regression) {
  if (file.has("current", !regression.current.empty())) {
    file.map("current", [&](auto& one) {
      describeRidge(one, regression.current, InputMemory::kCurrentColumns);
    });
    file.row("current_range_a", regression.min_current, regression.max_current);
    file.require(regression.min_current <= regression.max_current, "current_range_a", "must rise");
  }
  if (file.has("voltage", !regression.voltage.empty()))
    file.map("voltage", [&](auto& one) {
      describeRidge(one, regression.voltage, InputMemory::kVoltageColumns);
    });
}

template <typename File, typename Discrepancy>
void describeDiscrepancy(File& file, Discrepancy& d) {
  auto& c = d.context;
  file.row("context", c.interval, c.span, c.beta, c.high, c.high_width);
  file.require(c.interval >= 0.0 && c.span > 0.0 && c.beta > 0.0 && c.high_width > 0.0, "context",
               "must be interval (0 or more), span, beta (above 0), high and its width (above 0)");
  file.numbers("circuit", d.base_change, static_cast<std::size_t>(kBaseDirections));
  file.map("factor_std", [&](auto& stds) {
    if constexpr (File::kReads)
      for (const Mechanism mechanism : kAllMechanisms)
        if (stds.has(mechanismId(mechanism))) d.parts.push_back({mechanism, 0.0});
    for (auto& part : d.parts) stds.number(mechanismId(part.mechanism), part.std, {-1e6, 1e6});
  });
  static_cast<void>(file.has("numbers"));  // for who reads the file
  if constexpr (!File::kReads)
    file.texts("numbers",
               {"time", "scale", "charge", "lower", "upper", "centre", "spread", "weight_v"}, "");
  const auto resize = [&](std::size_t size) {
    if constexpr (File::kReads) {
      d.regressors.resize(size);
      for (Eigen::VectorXd* each : {&d.lower, &d.upper, &d.centre, &d.scale, &d.weight})
        each->setZero(static_cast<Eigen::Index>(size));
    }
  };
  file.list("regressors", d.regressors.size(), resize, [&](auto& one, std::size_t k) {
    auto& regressor = d.regressors[k];
    const auto j = static_cast<Eigen::Index>(k);
    one.oneOf("kind", regressor.kind, allRegressorKinds(), kindId);
    one.oneOf("mechanism", regressor.mechanism, kAllMechanisms, mechanismId);
    one.row("numbers", regressor.time, regressor.scale, regressor.charge, d.lower[j], d.upper[j],
            d.centre[j], d.scale[j], d.weight[j]);
  });
}

// ---------------------------------------------------------------------------------------------
// What is not as simple as a field.

void readDiscrepancy(const FieldReader& file, Fit& fit) {
  auto discrepancy = std::make_shared<DiscrepancyModel>();
  describeDiscrepancy(file, *discrepancy);
  orFail(file, "regressors", "cannot be used: ", [&] { discrepancyInfo(*discrepancy); });
  fit.discrepancy = discrepancy;
}

void readResponses(const FieldReader& file, FittedModel& model) {
  auto table = std::make_shared<ResponseTable>();
  describeResponses(file, *table);
  model.responses = table;
}

/// Runs the model for a second of discharge and of charge: voltage and interval must be numbers.
void requireRuns(const FieldReader& root, const FittedModel& model) {
  constexpr double kDuration = 1.0, kCurrent = 20.0;  // [s], [A]
  bool finite = true;
  orFail(root, "parameters", "and state cannot be run: ", [&] {
    for (const double current : {-kCurrent, kCurrent}) {
      Simulation simulation = uncertainSimulationOf(model);
      simulation.hold(current, kDuration);
      const Interval u = voltageAnswer(simulation, ResidualFilter(model).forecast(kDuration),
                                       model.fit.scores.rmse, model.intervals.calibrations.cranks);
      finite = finite && std::isfinite(u.value) && std::isfinite(u.lower) && std::isfinite(u.upper);
    }
  });
  root.require(finite, "parameters", "and state make no finite voltage");
}

/// Effects, parameters, state and covariance, which belong together.
template <typename File, typename Model>
void describeEquations(File& file, Model& model) {
  auto& fit = model.fit;
  auto ids = fit.effects;
  file.texts("effects", ids, "a list of ids");
  if constexpr (File::kReads)
    orFail(file, "effects",
           "cannot be used: ", [&] { fit.effects = BatteryModel(ids, fit.discrepancy).effects(); });
  const BatteryModel composition = compositionOf(fit);
  const Eigen::Index parameters = composition.parameterCount(), states = composition.stateCount();
  describeParameters(file, fit, composition);
  Eigen::VectorXd std = Eigen::VectorXd::Zero(parameters + states);
  Eigen::MatrixXd correlation(parameters + states, parameters + states);
  if constexpr (File::kReads) {
    file.map("parameters",
             [&](auto& all) { orFail(all, "", "", [&] { requireValid(fit.parameters); }); });
    for (Eigen::Index j = 0; j < parameters; ++j)
      std[j] = fit.estimates[static_cast<std::size_t>(j)].std.value_or(0.0);
  } else {
    correlation = correlationOf(fit.covariance);
    std = fit.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  }
  file.matrix("correlation", correlation);
  auto state_std = std.tail(states);
  file.map("state", [&](auto& state) { describeState(state, model, state_std, composition); });
  if constexpr (File::kReads) {
    requireCorrelation(file, correlation);
    fit.covariance = std.asDiagonal() * correlation * std.asDiagonal();
  }
}

template <typename File, typename Model>
void describeOrigin(File& file, Model& model) {
  file.map("recording", [&](auto& recording) {
    recording.text("name", model.provenance.recording);
    recording.text("hash", model.provenance.recording_hash);
    auto& serial_number = model.provenance.serial_number;
    if (recording.has("serial_number", !serial_number.empty()))
      recording.text("serial_number", serial_number);
  });
  auto& blocks = model.fit.series_blocks;
  if (!file.has("series_blocks", blocks != 1.0)) return;
  file.number("series_blocks", blocks);
  file.require(areSeriesBlocks(blocks), "series_blocks",
               format("is %g, expected ", blocks) + kAllowedSeriesBlocks);
}

/// All of a file but its schema. What cannot be used is refused by its equations first.
template <typename File, typename Model>
void describeModel(File& file, Model& model) {
  auto& fit = model.fit;
  if constexpr (!File::kReads) describeOrigin(file, model);
  if constexpr (File::kReads)
    if (file.has("discrepancy"))
      file.map("discrepancy", [&](auto& part) { readDiscrepancy(part, fit); });
  describeEquations(file, model);
  file.map("errors", [&](auto& part) { describeErrors(part, model); });
  file.map("window", [&](auto& part) { describeWindow(part, fit); });
  file.map("fit", [&](auto& part) { describeFit(part, model); });
  if (file.has("baseline"))
    file.map("baseline", [&](auto& part) { describeBaseline(part, fit.baseline); });
  if constexpr (File::kReads)
    if (file.has("source")) fit.source.emplace();
  if (fit.source) file.map("source", [&](auto& part) { describeSource(part, fit); });
  if (file.has("event_history"))
    file.map("event_history",
             [&](auto& part) { describeEvents(part, model.intervals.event_history); });
  auto& regression = fit.residual_regression;
  if (file.has("residual_regression", !regression.current.empty() || !regression.voltage.empty()))
    file.map("residual_regression", [&](auto& part) { describeRegression(part, regression); });
  if constexpr (!File::kReads)
    if (fit.discrepancy)
      file.map("discrepancy", [&](auto& part) { describeDiscrepancy(part, *fit.discrepancy); });
  if constexpr (!File::kReads)
    if (model.responses)
      file.map("responses", [&](auto& part) { describeResponses(part, *model.responses); });
  if constexpr (File::kReads)
    if (file.has("responses"))
      file.map("responses", [&](auto& part) { readResponses(part, model); });
  if constexpr (File::kReads) describeOrigin(file, model);
}

FittedModel modelOf(const FieldReader& file) {
  const std::string schema = file.text("schema");
  if (schema == kIdentificationSchema)
    file.fail("schema",
              std::string("is \"") + kIdentificationSchema +
                  "\", that of the JSON of sof identify, which has no covariance, and of model "
                  "files before 0.3, expected \"" +
                  kModelSchema + "\"; write the model file: sof identify REC --out MODEL.yaml");
  if (schema != kModelSchema)
    file.fail("schema", "is \"" + schema + "\", expected \"" + kModelSchema + "\"");
  FittedModel model;
  describeModel(file, model);
  static_cast<void>(file.has("program"));  // of no use to a reader
  file.refuseOthers();
  requireRuns(file, model);
  return model;
}

}  // namespace

std::string modelYaml(const FittedModel& model) {
  YAML::Node root;
  root["schema"] = kModelSchema;
  root["program"] = "battery_sof " + version();
  FieldWriter file(root);
  describeModel(file, model);
  YAML::Emitter out;
  out.SetDoublePrecision(17);
  out << YAML::Comment(
             "battery_sof model. Current is positive into the battery. correlation: rows and "
             "columns\n"
             "the parameters, then u_c2 and the further states. State: where a query's event "
             "begins.")
      << YAML::Newline << root;
  return std::string(out.c_str()) + "\n";
}

FittedModel parseModelYaml(const std::string& text, const std::string& source) {
  const YAML::Node document = documentOf(text, source);
  if (!document.IsMap()) throw ModelFileError(source + ": not a model: expected a YAML map");
  try {
    return modelOf(FieldReader(document, source));
  } catch (const YAML::Exception& error) {
    throw ModelFileError(source + ": line " + std::to_string(error.mark.line + 1) +
                         " cannot be understood");
  }
}

void writeModelFile(const std::filesystem::path& path, const FittedModel& model) {
  writeFileAtomically(path, modelYaml(model));
}

FittedModel readModelFile(const std::filesystem::path& path) {
  return parseModelYaml(textOfFile(path, kLargestFile), path.string());
}

}  // namespace battery_sof
