#include "battery_sof/report/model_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

#include "battery_sof/recording/atomic_file.hpp"
#include "battery_sof/report/version.hpp"
#include "force_yaml.hpp"
#include "yaml_reader.hpp"

namespace battery_sof {
namespace {

constexpr double kKelvin = 273.15;  // 0 degC

/// Rounded to twelve digits, so that writing, reading and writing again gives the same text.
double correlation(const Eigen::MatrixXd& covariance, int j, int k) {
  const double scale = std::sqrt(covariance(j, j) * covariance(k, k));
  return scale > 0.0 ? std::round(1e12 * covariance(j, k) / scale) / 1e12 : 0.0;
}

YAML::Node correlationNode(const Eigen::MatrixXd& covariance) {
  YAML::Node rows;
  for (int j = 0; j < covariance.rows(); ++j) {
    YAML::Node row;
    row.SetStyle(YAML::EmitterStyle::Flow);
    for (int k = 0; k < covariance.cols(); ++k) {
      row.push_back(scalar(j == k ? 1.0 : correlation(covariance, j, k)));
    }
    rows.push_back(row);
  }
  return rows;
}

YAML::Node parameterNode(const ParameterEstimate& estimate) {
  YAML::Node node;
  node.SetStyle(YAML::EmitterStyle::Flow);
  node["value"] = scalar(estimate.value);
  if (estimate.std) node["std"] = scalar(*estimate.std);
  node["unit"] = estimate.unit;
  if (estimate.held) node["held"] = true;
  node["at_bound"] = estimate.at_bound;
  node["determined"] = estimate.determined;
  return node;
}

YAML::Node stateNode(const FittedModel& model) {
  YAML::Node node;
  node["time_s"] = scalar(model.state.time);
  node["u_c2_v"] = scalar(model.state.u_c2);
  const auto std_of = [&](Eigen::Index row) { return std::sqrt(std::max(0.0, model.covariance(row, row))); };
  const BatteryModel composition = compositionOf(model);
  const Eigen::Index first = composition.parameterCount();
  node["u_c2_std_v"] = scalar(std_of(first));
  node["current_a"] = scalar(model.state.current);
  for (Eigen::Index j = 1; j < composition.stateCount(); ++j) {
    const StateInfo& info = composition.states()[static_cast<std::size_t>(j)];
    YAML::Node state;
    state.SetStyle(YAML::EmitterStyle::Flow);
    state["value"] = scalar(model.state.further[static_cast<std::size_t>(j) - 1]);
    state["std"] = scalar(std_of(first + j));
    state["unit"] = info.unit;
    node["further"][info.name] = state;
  }
  return node;
}

YAML::Node scaleNode(const IntervalScale& scale) {
  YAML::Node node;
  node.SetStyle(YAML::EmitterStyle::Flow);
  node["factor"] = scalar(scale.factor);
  node["events"] = scalar(scale.events);
  node["inside"] = scalar(scale.inside);
  return node;
}

/// What the model misses, and how wide its intervals must be.
YAML::Node errorsNode(const FittedModel& model) {
  YAML::Node node;
  if (model.noise) {
    node["white_std_v"] = scalar(model.noise->white_std);
    node["ar_std_v"] = scalar(model.noise->ar_std);
    node["ar_time_s"] = scalar(model.noise->ar_time);
    node["walk_std_v_per_sqrt_s"] = scalar(model.noise->walk_std);
    const Discrepancy& d = model.discrepancy;
    node["now"]["drift_v"] = scalar(d.drift);
    node["now"]["colored_v"] = scalar(d.colored);
    for (const double p : {d.p_dd, d.p_da, d.p_aa}) node["now"]["covariance_v2"].push_back(scalar(p));
    node["now"]["covariance_v2"].SetStyle(YAML::EmitterStyle::Flow);
  }
  node["crank_intervals"] = scaleNode(model.crank_scale);
  node["charge_intervals"] = scaleNode(model.charge_scale);
  return node;
}

YAML::Node sourceNode(const SourceRule& rule) {
  YAML::Node node;
  node["least_current_a"] = scalar(rule.least_current);
  node["charge_begins"] = rule.charge_begins == Imposed::kVoltage ? "voltage" : "current";
  node["current_noise_a"] = scalar(rule.current_noise);
  node["voltage_noise_v"] = scalar(rule.voltage_noise);
  if (rule.resistance) node["resistance_ohm"] = scalar(*rule.resistance);
  node["max_gap_s"] = scalar(rule.max_gap);
  return node;
}

/// Written as rows of numbers; what each one is stands in docs/model.md.
YAML::Node naiveNode(const NaivePredictor& naive) {
  YAML::Node node(YAML::NodeType::Map);
  const auto line = [](const NaiveLine& l) {
    return flow({l.intercept, l.slope, l.std, l.lower_error, l.upper_error, l.centre, l.spread, static_cast<double>(l.samples)});
  };
  const auto history = [](const NaiveHistory& h) {
    return flow({h.median, h.last, h.lower_error, h.upper_error, static_cast<double>(h.events)});
  };
  if (naive.current_from_voltage) node["current_from_voltage"] = line(*naive.current_from_voltage);
  if (naive.voltage_from_current) node["voltage_from_current"] = line(*naive.voltage_from_current);
  if (naive.phase) {
    const NaivePhase& p = *naive.phase;
    node["phase"]["current_a"] = flow(p.current);
    node["phase"]["step_s"] = scalar(p.step);
    node["phase"]["errors"] = flow({p.std, p.lower_error, p.upper_error, static_cast<double>(p.charges)});
  }
  if (naive.cranks) {
    const NaiveCranks& c = *naive.cranks;
    node["cranks"] = flow({c.last.current, c.last.minimum, c.median.current, c.median.minimum, c.intercept, c.slope,
                           c.lower_error, c.upper_error, static_cast<double>(c.events)});
  }
  if (naive.charge_10s) node["charge_10s"] = history(*naive.charge_10s);
  if (naive.charge_60s) node["charge_60s"] = history(*naive.charge_60s);
  return node;
}

YAML::Node experienceNode(const Experience& experience) {
  YAML::Node node(YAML::NodeType::Map);
  for (const PastCrank& c : experience.cranks)
    node["cranks"].push_back(flow({c.time, c.current, c.minimum, c.modelled}));
  for (const PastCharge& c : experience.charges)
    node["charges"].push_back(flow({c.time, c.duration, c.voltage, c.first_voltage, c.measured, c.modelled}));
  return node;
}

std::vector<double> numbersOf(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

YAML::Node ridgeNode(const RidgeFit& fit) {
  YAML::Node node;
  node["centre"] = flow(numbersOf(fit.centre));
  node["scale"] = flow(numbersOf(fit.scale));
  node["weight"] = flow(numbersOf(fit.weight));
  node["lower"] = flow(numbersOf(fit.lower));
  node["upper"] = flow(numbersOf(fit.upper));
  node["constant"] = scalar(fit.constant);
  node["penalty"] = scalar(fit.penalty);
  node["gain"] = scalar(fit.gain);
  return node;
}

YAML::Node windowNode(const FittedModel& model) {
  YAML::Node node;
  node["from_s"] = scalar(model.window.from);
  node["to_s"] = scalar(model.window.to);
  node["samples"] = scalar(model.window.samples);
  node["min_current_a"] = scalar(model.excited.min_current);
  node["max_current_a"] = scalar(model.excited.max_current);
  node["min_voltage_v"] = scalar(model.excited.min_voltage);
  node["max_voltage_v"] = scalar(model.excited.max_voltage);
  node["discharge_time_s"] = scalar(model.excited.discharge_time);
  node["charge_time_s"] = scalar(model.excited.charge_time);
  node["longest_discharge_s"] = scalar(model.excited.longest_discharge);
  node["longest_charge_s"] = scalar(model.excited.longest_charge);
  if (model.excited.temperature) node["temperature_c"] = scalar(*model.excited.temperature - kKelvin);
  return node;
}

YAML::Node fitNode(const FittedModel& model) {
  YAML::Node node;
  node["status"] = describe(model.status);
  node["message"] = model.message;
  node["start"] = model.start;
  node["iterations"] = scalar(model.iterations);
  node["q_dyn_percent"] = scalar(model.scores.q_dyn_percent);
  node["rmse_v"] = scalar(model.scores.rmse);
  if (model.scores.current_rmse) node["current_rmse_a"] = scalar(*model.scores.current_rmse);
  if (model.scores.left_out_share_percent) node["left_out_share_percent"] = scalar(*model.scores.left_out_share_percent);
  node["crank_error_v"] = scalar(model.scores.crank_error_std);
  node["cranks"] = scalar(model.scores.cranks);
  node["residual_correlation_time_s"] = scalar(model.scores.residual_correlation_time);
  node["suitability"] = scalar(model.suitability);
  node["fit_ms"] = scalar(model.fit_ms);
  return node;
}

FitStatus statusOf(const Reader& fit) {
  const std::string text = fit.text("status");
  for (FitStatus status : {FitStatus::kConverged, FitStatus::kIterationLimit, FitStatus::kStalled,
                           FitStatus::kWindowTooShort, FitStatus::kNotExcited})
    if (describe(status) == text) return status;
  fit.fail("status", "is \"" + text +
                         "\", expected converged, iteration_limit, stalled, "
                         "window_too_short or not_excited");
}

ParameterEstimate estimateOf(const Reader& parameters, const std::string& name) {
  const Reader field = parameters.at(name);
  ParameterEstimate estimate;
  estimate.name = name;
  estimate.unit = field.text("unit");
  estimate.value = field.number("value");
  if (field.has("std")) estimate.std = field.number("std");
  if (field.has("held")) estimate.held = field.get<bool>("held", "true or false");
  estimate.at_bound = field.get<bool>("at_bound", "true or false");
  estimate.determined = field.get<bool>("determined", "true or false");
  return estimate;
}

void readParameters(const Reader& root, FittedModel& model) {
  const Reader parameters = root.at("parameters");
  const BatteryModel composition = compositionOf(model);
  for (const ParameterInfo& info : composition.parameters())
    model.estimates.push_back(estimateOf(parameters, info.name));
  const Reader fixed = root.at("fixed");
  auto& p = model.parameters;
  p.r_discharge = model.estimates[kRowRDischarge].value;
  p.r_charge = model.estimates[kRowRCharge].value;
  p.c2 = model.estimates[kRowC2].value;
  p.beta = model.estimates[kRowBeta].value;
  p.u_dc = model.estimates[kRowUDc].value;
  p.i0 = fixed.number("i0_a");
  p.alpha = fixed.number("alpha");
  try {
    requireValid(p);
  } catch (const std::invalid_argument& error) {
    parameters.fail("", error.what());
  }
}

/// What "parameters" and "effects" say must be a composition.
void readEffects(const Reader& root, FittedModel& model) {
  const auto ids = root.get<std::vector<std::string>>("effects", "a list of ids");
  if (root.has("force")) model.force = std::make_shared<const LearnedForce>(forceOf(root.at("force")));
  try {
    model.effects = BatteryModel(ids, model.force).effects();
  } catch (const std::invalid_argument& error) {
    root.fail("effects", std::string("cannot be used: ") + error.what());
  }
}

void readState(const Reader& root, FittedModel& model) {
  const Reader state = root.at("state");
  model.state = {state.number("time_s"), state.number("u_c2_v"), state.number("current_a")};
  const BatteryModel composition = compositionOf(model);
  for (std::size_t j = 1; j < composition.states().size(); ++j)
    model.state.further.push_back(
        state.at("further").at(composition.states()[j].name).number("value"));
}

void readCovariance(const Reader& root, FittedModel& model) {
  const BatteryModel composition = compositionOf(model);
  const Eigen::Index parameters = composition.parameterCount();
  const Eigen::Index size = parameters + composition.stateCount();
  const std::string expected = std::to_string(size) + " rows of " + std::to_string(size) + " numbers";
  const auto rows = root.rows("correlation", expected.c_str());
  const Reader state = root.at("state");
  Eigen::VectorXd std(size);
  for (Eigen::Index j = 0; j < parameters; ++j)
    std[j] = model.estimates[static_cast<std::size_t>(j)].std.value_or(0.0);
  std[parameters] = state.number("u_c2_std_v");
  for (Eigen::Index j = 1; j < composition.stateCount(); ++j)
    std[parameters + j] = state.at("further")
                              .at(composition.states()[static_cast<std::size_t>(j)].name)
                              .number("std");
  model.covariance.resize(size, size);
  const auto wanted = static_cast<std::size_t>(size);
  for (std::size_t j = 0; j < wanted; ++j)
    for (std::size_t k = 0; k < wanted; ++k) {
      if (rows.size() != wanted || rows[j].size() != wanted || !(std::abs(rows[j][k]) <= 1.0 + 1e-9))
        root.fail("correlation", "must be " + expected + " between -1 and 1");
      const auto row = static_cast<Eigen::Index>(j), column = static_cast<Eigen::Index>(k);
      model.covariance(row, column) = rows[j][k] * std[row] * std[column];
    }
}

IntervalScale scaleOf(const Reader& field) {
  IntervalScale scale;
  scale.factor = field.number("factor");
  scale.events = field.get<int>("events", "a whole number");
  scale.inside = field.get<int>("inside", "a whole number");
  if (!(scale.factor > 0.0) || scale.inside < 0 || scale.events < scale.inside)
    field.fail("factor", "must be above 0, with events >= inside >= 0");
  return scale;
}

/// Files of earlier versions have no "errors".
void readErrors(const Reader& root, FittedModel& model) {
  if (!root.has("errors")) return;
  const Reader errors = root.at("errors");
  model.crank_scale = scaleOf(errors.at("crank_intervals"));
  model.charge_scale = scaleOf(errors.at("charge_intervals"));
  if (!errors.has("white_std_v")) return;
  const NoiseModel noise{errors.number("white_std_v"), errors.number("ar_std_v"), errors.number("ar_time_s"),
                         errors.number("walk_std_v_per_sqrt_s")};
  if (!(noise.white_std > 0.0 && noise.ar_std >= 0.0 && noise.ar_time > 0.0 && noise.walk_std >= 0.0))
    errors.fail("white_std_v", "and its neighbours must be above 0");
  model.noise = noise;
  const Reader now = errors.at("now");
  const auto p = now.numbers("covariance_v2", "three numbers");
  if (p.size() != 3) now.fail("covariance_v2", "must be three numbers");
  model.discrepancy = {now.number("drift_v"), now.number("colored_v"), p[0], p[1], p[2]};
}

void readWindow(const Reader& root, FittedModel& model) {
  const Reader window = root.at("window");
  model.window = {window.number("from_s"), window.number("to_s"),
                  window.get<std::size_t>("samples", "a whole number")};
  auto& excited = model.excited;
  excited.min_current = window.number("min_current_a");
  excited.max_current = window.number("max_current_a");
  excited.min_voltage = window.number("min_voltage_v");
  excited.max_voltage = window.number("max_voltage_v");
  excited.discharge_time = window.number("discharge_time_s");
  excited.charge_time = window.number("charge_time_s");
  if (window.has("longest_discharge_s")) excited.longest_discharge = window.number("longest_discharge_s");
  if (window.has("longest_charge_s")) excited.longest_charge = window.number("longest_charge_s");
  if (window.has("temperature_c")) excited.temperature = window.number("temperature_c") + kKelvin;
}

void readFit(const Reader& root, FittedModel& model) {
  const Reader fit = root.at("fit");
  model.status = statusOf(fit);
  model.message = fit.text("message");
  model.start = fit.text("start");
  model.iterations = fit.get<int>("iterations", "a whole number");
  model.scores.q_dyn_percent = fit.number("q_dyn_percent");
  model.scores.rmse = fit.number("rmse_v");
  if (fit.has("current_rmse_a")) model.scores.current_rmse = fit.number("current_rmse_a");
  if (fit.has("left_out_share_percent")) model.scores.left_out_share_percent = fit.number("left_out_share_percent");
  model.scores.crank_error_std = fit.number("crank_error_v");
  model.scores.cranks = fit.get<int>("cranks", "a whole number");
  model.scores.residual_correlation_time = fit.number("residual_correlation_time_s");
  model.suitability = fit.number("suitability");
  model.fit_ms = fit.number("fit_ms");
}

std::vector<double> numbersOf(const Reader& node, const std::string& key, std::size_t count) {
  const std::string expected = std::to_string(count) + " numbers";
  const auto values = node.numbers(key, expected.c_str());
  if (values.size() != count) node.fail(key, "has " + std::to_string(values.size()) + " numbers, expected " + std::to_string(count));
  for (const double value : values)
    if (!std::isfinite(value)) node.fail(key, "holds a number that is not finite");
  return values;
}

std::vector<std::vector<double>> rowsOf(const Reader& node, const std::string& key, std::size_t count) {
  if (!node.has(key)) return {};
  const std::string expected = "rows of " + std::to_string(count) + " numbers";
  const auto rows = node.rows(key, expected.c_str());
  for (const auto& row : rows) {
    if (row.size() != count) node.fail(key, "must be " + expected);
    for (const double value : row)
      if (!std::isfinite(value)) node.fail(key, "holds a number that is not finite");
  }
  return rows;
}

void readNaive(const Reader& root, FittedModel& model) {
  if (!root.has("naive")) return;
  const Reader node = root.at("naive");
  const auto line = [&](const char* key) -> std::optional<NaiveLine> {
    if (!node.has(key)) return std::nullopt;
    const auto x = numbersOf(node, key, 8);
    NaiveLine l;
    l.intercept = x[0];
    l.slope = x[1];
    l.std = x[2];
    l.lower_error = x[3];
    l.upper_error = x[4];
    l.centre = x[5];
    l.spread = x[6];
    l.samples = static_cast<std::size_t>(x[7]);
    return l;
  };
  const auto history = [&](const char* key) -> std::optional<NaiveHistory> {
    if (!node.has(key)) return std::nullopt;
    const auto x = numbersOf(node, key, 5);
    NaiveHistory h;
    h.median = x[0];
    h.last = x[1];
    h.lower_error = x[2];
    h.upper_error = x[3];
    h.events = static_cast<std::size_t>(x[4]);
    return h;
  };
  model.naive.current_from_voltage = line("current_from_voltage");
  model.naive.voltage_from_current = line("voltage_from_current");
  model.naive.charge_10s = history("charge_10s");
  model.naive.charge_60s = history("charge_60s");
  if (node.has("phase")) {
    const Reader phase = node.at("phase");
    NaivePhase p;
    p.current = phase.numbers("current_a", "numbers");
    p.step = phase.number("step_s");
    const auto errors = numbersOf(phase, "errors", 4);
    p.std = errors[0];
    p.lower_error = errors[1];
    p.upper_error = errors[2];
    p.charges = static_cast<std::size_t>(errors[3]);
    if (p.current.empty() || !(p.step > 0.0)) phase.fail("current_a", "must not be empty, step_s above 0");
    model.naive.phase = p;
  }
  if (node.has("cranks")) {
    const auto x = numbersOf(node, "cranks", 9);
    NaiveCranks c;
    c.last = {x[0], x[1]};
    c.median = {x[2], x[3]};
    c.intercept = x[4];
    c.slope = x[5];
    c.lower_error = x[6];
    c.upper_error = x[7];
    c.events = static_cast<std::size_t>(x[8]);
    model.naive.cranks = c;
  }
}

void readSource(const Reader& root, FittedModel& model) {
  if (!root.has("source")) return;
  const Reader node = root.at("source");
  SourceRule rule;
  rule.present = true;
  rule.least_current = node.number("least_current_a");
  const std::string begins = node.text("charge_begins");
  if (begins != "voltage" && begins != "current")
    node.fail("charge_begins", "is \"" + begins + "\", expected voltage or current");
  rule.charge_begins = begins == "voltage" ? Imposed::kVoltage : Imposed::kCurrent;
  rule.current_noise = node.number("current_noise_a");
  rule.voltage_noise = node.number("voltage_noise_v");
  if (node.has("resistance_ohm")) rule.resistance = node.number("resistance_ohm");
  rule.max_gap = node.number("max_gap_s");
  try {
    SourceWatch sound(rule);
  } catch (const std::invalid_argument& error) {
    node.fail("least_current_a", std::string("and its neighbours cannot be used: ") + error.what());
  }
  model.source = rule;
  model.voltage_lag = node.get<std::size_t>("voltage_lag_samples", "a whole number");
}

void readExperience(const Reader& root, FittedModel& model) {
  if (!root.has("experience")) return;
  const Reader node = root.at("experience");
  for (const auto& x : rowsOf(node, "cranks", 4)) model.experience.add(PastCrank{x[0], x[1], x[2], x[3]});
  for (const auto& x : rowsOf(node, "charges", 6))
    model.experience.add(PastCharge{x[0], x[1], x[2], x[3], x[4], x[5]});
}

RidgeFit ridgeOf(const Reader& node) {
  const auto take = [&](const char* key) {
    const auto x = node.numbers(key, "numbers");
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size())));
  };
  RidgeFit fit;
  fit.centre = take("centre");
  fit.scale = take("scale");
  fit.weight = take("weight");
  fit.lower = take("lower");
  fit.upper = take("upper");
  fit.constant = node.number("constant");
  fit.penalty = node.number("penalty");
  fit.gain = node.number("gain");
  const bool fits = fit.centre.size() == fit.weight.size() && fit.scale.size() == fit.weight.size() &&
                    fit.lower.size() == fit.upper.size() &&
                    (fit.lower.size() == 0 || fit.lower.size() == fit.weight.size());
  const bool finite = fit.centre.allFinite() && fit.scale.allFinite() && fit.weight.allFinite() &&
                      fit.lower.allFinite() && fit.upper.allFinite();
  if (!fits || !finite || !(fit.scale.array() > 0.0).all())
    node.fail("weight", "and its neighbours must be as many finite numbers, scales above 0");
  return fit;
}

void readLearned(const Reader& root, FittedModel& model) {
  if (root.at("state").has("memory"))
    model.state.memory = DriveMemory::fromNumbers(numbersOf(root.at("state"), "memory", DriveMemory::kNumbers));
  if (model.force) model.state.force_memory = numbersOf(root.at("state"), "force_memory", model.force->memorySize());
  if (!root.has("learned")) return;
  const Reader node = root.at("learned");
  const auto read = [&](const char* key, Eigen::Index columns, RidgeFit& fit) {
    if (!node.has(key)) return;
    fit = ridgeOf(node.at(key));
    if (fit.weight.size() != columns)
      node.at(key).fail("weight", "has " + std::to_string(fit.weight.size()) + " numbers, expected " + std::to_string(columns));
  };
  read("current", DriveMemory::kCurrentColumns, model.learned.current);
  if (node.has("current")) {
    const auto range = numbersOf(node, "current_range_a", 2);
    model.learned.least_current = range[0];
    model.learned.most_current = range[1];
    if (!(range[0] <= range[1])) node.fail("current_range_a", "must rise");
  }
  read("voltage", DriveMemory::kVoltageColumns, model.learned.voltage);
}

}  // namespace

std::string modelYaml(const FittedModel& model) {
  YAML::Node root;
  root["schema"] = kModelSchema;
  root["program"] = "battery_sof " + version();
  root["recording"]["name"] = model.recording;
  root["recording"]["hash"] = model.recording_hash;
  root["effects"] = YAML::Node(YAML::NodeType::Sequence);
  root["effects"].SetStyle(YAML::EmitterStyle::Flow);
  for (const auto& effect : model.effects) root["effects"].push_back(effect);
  for (const auto& estimate : model.estimates)
    root["parameters"][estimate.name] = parameterNode(estimate);
  root["fixed"]["i0_a"] = scalar(model.parameters.i0);
  root["fixed"]["alpha"] = scalar(model.parameters.alpha);
  root["correlation"] = correlationNode(model.covariance);
  root["state"] = stateNode(model);
  root["errors"] = errorsNode(model);
  root["window"] = windowNode(model);
  root["fit"] = fitNode(model);
  root["naive"] = naiveNode(model.naive);
  if (model.source) {
    root["source"] = sourceNode(*model.source);
    root["source"]["voltage_lag_samples"] = scalar(model.voltage_lag);
  }
  root["experience"] = experienceNode(model.experience);
  if (!model.learned.current.empty()) {
    root["learned"]["current"] = ridgeNode(model.learned.current);
    root["learned"]["current_range_a"] = flow({model.learned.least_current, model.learned.most_current});
  }
  if (!model.learned.voltage.empty()) root["learned"]["voltage"] = ridgeNode(model.learned.voltage);
  if (model.state.memory.begun) root["state"]["memory"] = flow(model.state.memory.numbers());
  if (model.force) {
    root["force"] = forceNode(*model.force);
    root["state"]["force_memory"] = flow(model.state.force_memory);
  }

  YAML::Emitter out;
  out.SetDoublePrecision(17);
  out << YAML::Comment(
             "battery_sof model. Current is positive into the battery. correlation: rows and "
             "columns\n"
             "the parameters, then u_c2 and the further states. State: where a query's event begins.")
      << YAML::Newline << root;
  return std::string(out.c_str()) + "\n";
}

FittedModel parseModelYaml(const std::string& text, const std::string& source) {
  YAML::Node document;
  try {
    document = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw ModelFileError(source + ": not YAML: " + error.what());
  }
  const Reader root(document, source, "");
  if (!document.IsMap()) throw ModelFileError(source + ": not a model: expected a YAML map");
  const std::string schema = root.text("schema");
  if (schema != kModelSchema)
    root.fail("schema", "is \"" + schema + "\", expected \"" + kModelSchema + "\"");

  FittedModel model;
  readEffects(root, model);
  readParameters(root, model);
  readState(root, model);
  readCovariance(root, model);
  readErrors(root, model);
  readWindow(root, model);
  readFit(root, model);
  readNaive(root, model);
  readSource(root, model);
  readExperience(root, model);
  readLearned(root, model);
  model.recording = root.at("recording").text("name");
  model.recording_hash = root.at("recording").text("hash");
  return model;
}

void writeModelFile(const std::filesystem::path& path, const FittedModel& model) {
  writeFileAtomically(path, modelYaml(model));
}

FittedModel readModelFile(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw ModelFileError(path.string() + ": cannot be read");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return parseModelYaml(text, path.string());
}

}  // namespace battery_sof
