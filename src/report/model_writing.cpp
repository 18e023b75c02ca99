#include <yaml-cpp/yaml.h>

#include <cmath>

#include "battery_sof/version.hpp"
#include "discrepancy_yaml.hpp"
#include "report/model_yaml.hpp"
#include "util/constants.hpp"
#include "yaml_reader.hpp"

namespace battery_sof {
namespace {

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
  if (estimate.std) node["std_error"] = scalar(*estimate.std);
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
  const auto std_of = [&](Eigen::Index row) {
    return std::sqrt(std::max(0.0, model.fit.covariance(row, row)));
  };
  const BatteryModel composition = compositionOf(model.fit);
  const Eigen::Index first = composition.parameterCount();
  node["u_c2_std_v"] = scalar(std_of(first));
  node["current_a"] = scalar(model.state.current);
  for (Eigen::Index j = 1; j < composition.stateCount(); ++j) {
    const StateInfo& info = composition.states()[static_cast<std::size_t>(j)];
    YAML::Node state;
    state.SetStyle(YAML::EmitterStyle::Flow);
    state["value"] = scalar(model.state.further[static_cast<std::size_t>(j) - 1]);
    state["std_error"] = scalar(std_of(first + j));
    state["unit"] = info.unit;
    node["further"][info.name] = state;
  }
  return node;
}

YAML::Node calibrationNode(const IntervalCalibration& scale) {
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
  if (model.fit.noise) {
    node["white_std_v"] = scalar(model.fit.noise->white_std);
    node["ar_std_v"] = scalar(model.fit.noise->ar_std);
    node["ar_time_s"] = scalar(model.fit.noise->ar_time);
    node["walk_std_v_per_sqrt_s"] = scalar(model.fit.noise->walk_std);
    const ResidualState& d = model.state.residual_state;
    node["now"]["drift_v"] = scalar(d.drift);
    node["now"]["colored_v"] = scalar(d.colored);
    for (const double p : {d.p_dd, d.p_da, d.p_aa})
      node["now"]["covariance_v2"].push_back(scalar(p));
    node["now"]["covariance_v2"].SetStyle(YAML::EmitterStyle::Flow);
  }
  node["crank_intervals"] = calibrationNode(model.intervals.crank_calibration);
  node["charge_intervals"] = calibrationNode(model.intervals.charge_calibration);
  return node;
}

YAML::Node sourceNode(const ControlModeRule& rule) {
  YAML::Node node;
  node["min_current_a"] = scalar(rule.min_current);
  node["charge_begins"] = rule.charge_begins == ControlMode::kVoltage ? "voltage" : "current";
  node["current_noise_a"] = scalar(rule.current_noise);
  node["voltage_noise_v"] = scalar(rule.voltage_noise);
  if (rule.resistance) node["resistance_ohm"] = scalar(*rule.resistance);
  node["max_gap_s"] = scalar(rule.max_gap);
  return node;
}

/// Written as rows of numbers; what each one is stands in docs/model-file.md.
YAML::Node baselineNode(const BaselinePredictor& baseline) {
  YAML::Node node(YAML::NodeType::Map);
  const auto line = [](const BaselineLine& l) {
    return flow({l.intercept, l.slope, l.std, l.lower_error, l.upper_error, l.centre, l.spread,
                 static_cast<double>(l.samples)});
  };
  const auto history = [](const BaselineHistory& h) {
    return flow({h.median, h.last, h.lower_error, h.upper_error, static_cast<double>(h.events)});
  };
  if (baseline.current_from_voltage)
    node["current_from_voltage"] = line(*baseline.current_from_voltage);
  if (baseline.voltage_from_current)
    node["voltage_from_current"] = line(*baseline.voltage_from_current);
  if (baseline.phase) {
    const BaselinePhase& p = *baseline.phase;
    node["phase"]["current_a"] = flow(p.current);
    node["phase"]["step_s"] = scalar(p.step);
    node["phase"]["errors"] =
        flow({p.std, p.lower_error, p.upper_error, static_cast<double>(p.charges)});
  }
  if (baseline.cranks) {
    const BaselineCranks& c = *baseline.cranks;
    node["cranks"] =
        flow({c.last.current, c.last.minimum, c.median.current, c.median.minimum, c.intercept,
              c.slope, c.lower_error, c.upper_error, static_cast<double>(c.events)});
  }
  if (baseline.charge_10s) node["charge_10s"] = history(*baseline.charge_10s);
  if (baseline.charge_60s) node["charge_60s"] = history(*baseline.charge_60s);
  return node;
}

YAML::Node eventHistoryNode(const EventHistory& event_history) {
  YAML::Node node(YAML::NodeType::Map);
  for (const PastCrank& c : event_history.cranks)
    node["cranks"].push_back(flow({c.time, c.current, c.minimum, c.modelled}));
  for (const PastCharge& c : event_history.charges)
    node["charges"].push_back(
        flow({c.time, c.duration, c.voltage, c.first_voltage, c.measured, c.modelled}));
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

YAML::Node windowNode(const Fit& fit) {
  YAML::Node node;
  node["from_s"] = scalar(fit.window.from);
  node["to_s"] = scalar(fit.window.to);
  node["samples"] = scalar(fit.window.samples);
  node["min_current_a"] = scalar(fit.excited.min_current);
  node["max_current_a"] = scalar(fit.excited.max_current);
  node["min_voltage_v"] = scalar(fit.excited.min_voltage);
  node["max_voltage_v"] = scalar(fit.excited.max_voltage);
  node["discharge_time_s"] = scalar(fit.excited.discharge_time);
  node["charge_time_s"] = scalar(fit.excited.charge_time);
  node["longest_discharge_s"] = scalar(fit.excited.longest_discharge);
  node["longest_charge_s"] = scalar(fit.excited.longest_charge);
  node["charge_swing_ah"] = scalar(fit.excited.charge_swing);
  if (fit.excited.temperature)
    node["temperature_c"] = scalar(*fit.excited.temperature - kZeroCelsius);
  return node;
}

YAML::Node fitNode(const FittedModel& model) {
  YAML::Node node;
  node["status"] = toString(model.fit.status);
  node["message"] = model.fit.message;
  node["start"] = model.fit.start;
  node["iterations"] = scalar(model.fit.iterations);
  node["q_dyn_percent"] = scalar(model.fit.scores.q_dyn_percent);
  node["rmse_v"] = scalar(model.fit.scores.rmse);
  if (model.fit.scores.current_rmse)
    node["current_rmse_a"] = scalar(*model.fit.scores.current_rmse);
  if (model.fit.scores.left_out_share_percent)
    node["left_out_share_percent"] = scalar(*model.fit.scores.left_out_share_percent);
  node["crank_error_v"] = scalar(model.fit.scores.crank_error_std);
  node["cranks"] = scalar(model.fit.scores.cranks);
  node["residual_correlation_time_s"] = scalar(model.fit.scores.residual_correlation_time);
  node["window_quality"] = scalar(model.fit.window_quality);
  node["fit_ms"] = scalar(model.provenance.fit_ms);
  return node;
}

void takeDiscrepancy(YAML::Node& root, const ResidualRegression& residual_regression) {
  if (!residual_regression.current.empty()) {
    root["residual_regression"]["current"] = ridgeNode(residual_regression.current);
    root["residual_regression"]["current_range_a"] =
        flow({residual_regression.min_current, residual_regression.max_current});
  }
  if (!residual_regression.voltage.empty())
    root["residual_regression"]["voltage"] = ridgeNode(residual_regression.voltage);
}

}  // namespace

std::string modelYaml(const FittedModel& model) {
  YAML::Node root;
  root["schema"] = kModelSchema;
  root["program"] = "battery_sof " + version();
  root["recording"]["name"] = printable(model.provenance.recording);
  root["recording"]["hash"] = model.provenance.recording_hash;
  if (model.fit.series_blocks != 1.0) root["series_blocks"] = scalar(model.fit.series_blocks);
  root["effects"] = YAML::Node(YAML::NodeType::Sequence);
  root["effects"].SetStyle(YAML::EmitterStyle::Flow);
  for (const auto& effect : model.fit.effects) root["effects"].push_back(effect);
  for (const auto& estimate : model.fit.estimates)
    root["parameters"][estimate.name] = parameterNode(estimate);
  root["fixed"]["i0_a"] = scalar(model.fit.parameters.i0);
  root["fixed"]["alpha"] = scalar(model.fit.parameters.alpha);
  root["correlation"] = correlationNode(model.fit.covariance);
  root["state"] = stateNode(model);
  root["errors"] = errorsNode(model);
  root["window"] = windowNode(model.fit);
  root["fit"] = fitNode(model);
  root["baseline"] = baselineNode(model.fit.baseline);
  if (model.fit.source) {
    root["source"] = sourceNode(*model.fit.source);
    root["source"]["voltage_lag_samples"] = scalar(model.fit.voltage_lag);
  }
  root["event_history"] = eventHistoryNode(model.intervals.event_history);
  takeDiscrepancy(root, model.fit.residual_regression);
  if (model.state.memory.begun) root["state"]["memory"] = flow(model.state.memory.numbers());
  if (model.fit.discrepancy) {
    root["discrepancy"] = discrepancyNode(*model.fit.discrepancy);
    root["state"]["regressor_memory"] = flow(model.state.regressor_memory);
  }

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

}  // namespace battery_sof
