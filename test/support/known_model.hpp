#pragma once

#include "state/fitted_model.hpp"
#include "support/composed.hpp"

/// Models whose parameters are known exactly and whose window excited nearly everything, for tests
/// of queries.
namespace battery_sof::test {

inline FittedModel knownModel(const std::vector<std::string>& effects = {}, double u_c2 = 0.0) {
  const BatteryModel composition(effects);
  const Eigen::VectorXd p = typicalPoint(composition);
  FittedModel model;
  model.fit.effects = effects;
  model.fit.parameters = drivenBattery();
  for (Eigen::Index j = 0; j < p.size(); ++j) {
    const ParameterInfo& info = composition.parameters()[static_cast<std::size_t>(j)];
    ParameterEstimate estimate;
    estimate.name = info.name;
    estimate.unit = info.unit;
    estimate.value = p[j];
    estimate.std = 0.0;
    model.fit.estimates.push_back(estimate);
  }
  const Eigen::Index rows = p.size() + composition.stateCount();
  model.fit.covariance = Eigen::MatrixXd::Zero(rows, rows);
  model.state = {100.0, 0.0, composition.restState()};
  model.state.states[0] = u_c2;
  model.fit.window = {0.0, 100.0, 10000};
  model.fit.excited.min_current = -400.0;
  model.fit.excited.max_current = 400.0;
  model.fit.excited.min_voltage = 9.0;
  model.fit.excited.max_voltage = 15.0;
  model.fit.excited.longest_charge = 60.0;
  model.fit.window_quality = 0.8;
  model.fit.message = "known";
  return model;
}

/// The same with a standard error of `share` of each base parameter.
inline FittedModel uncertainModel(double share, const std::vector<std::string>& effects = {}) {
  FittedModel model = knownModel(effects);
  for (Eigen::Index j = 0; j < kBaseRows; ++j) {
    ParameterEstimate& estimate = model.fit.estimates[static_cast<std::size_t>(j)];
    estimate.std = j == kBaseRows - 1 ? 0.01 : share * estimate.value;  // u_dc: 10 mV
    model.fit.covariance(j, j) = *estimate.std * *estimate.std;
  }
  return model;
}

/// Takes the base parameters over from the estimates.
inline void takeEstimates(Fit& fit) {
  Eigen::VectorXd p(static_cast<Eigen::Index>(kBaseRows));
  for (Eigen::Index j = 0; j < p.size(); ++j)
    p[j] = fit.estimates[static_cast<std::size_t>(j)].value;
  fit.parameters = baseParameters(p);
}

/// The same with every parameter at the composition's magnitude, those of the circuit that an effect
/// gives another meaning among them.
inline FittedModel typicalBattery(const std::vector<std::string>& effects) {
  FittedModel model = knownModel(effects);
  const Eigen::VectorXd p = BatteryModel(effects).typicalParameters();
  for (Eigen::Index j = 0; j < p.size(); ++j)
    if (j != kRowUDc) model.fit.estimates[static_cast<std::size_t>(j)].value = p[j];
  takeEstimates(model.fit);
  return model;
}

inline bool holds(const std::string& text, const std::string& piece) {
  return text.find(piece) != std::string::npos;
}

/// A model whose voltage leaves the range of numbers some 40 s after its state's time [s]: no file may
/// hold it.
inline FittedModel overflowingModel(double time) {
  FittedModel model = knownModel({"voltage_drift"});
  for (ParameterEstimate& estimate : model.fit.estimates)
    if (estimate.name == "u_dc" || estimate.name == "voltage_drift") estimate.value = 1.7e308;
  takeEstimates(model.fit);
  model.fit.window.from = time - 160.0;
  model.state.time = model.fit.window.to = time;
  return model;
}

}  // namespace battery_sof::test
