#include "state/fitted_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "util/eigen_decomposition.hpp"

namespace battery_sof {
namespace {

// Of stops (docs/decisions/0018-stops.md): how far the level moves from one to the next, and how one
// differs from it [V].
constexpr double kStopWalk = 0.04, kStopNoise = 0.08;
// Stops that the first guess of the spread counts as, and how much of the past spread each keeps.
constexpr double kGuessedStops = 3.0, kKept = 0.9;

}  // namespace

PastEvent measuredCrank(const Series& series, IndexRange range) {
  const auto current = series.current.begin(), voltage = series.voltage.begin();
  const auto lowest = std::min_element(voltage + range.first, voltage + range.last);
  PastEvent crank;
  crank.time = series.time[static_cast<std::size_t>(lowest - voltage)];
  crank.current = *std::min_element(current + range.first, current + range.last);
  crank.measured = *lowest;
  return crank;
}

PastEvent measuredCharge(const Series& series, IndexRange samples, double duration) {
  PastEvent charge{PastEvent::Kind::kCharge, series.time[samples.first], duration};
  charge.first_voltage = series.voltage[samples.first];
  for (std::size_t n = samples.first; n < samples.last; ++n) {
    charge.voltage += series.voltage[n];
    charge.measured += series.current[n];
  }
  charge.voltage /= static_cast<double>(samples.size());
  charge.measured /= static_cast<double>(samples.size());
  return charge;
}

void EventHistory::add(const PastEvent& event) {
  const bool is_charge = event.kind == PastEvent::Kind::kCharge;
  auto& past = is_charge ? charges : event.kind == PastEvent::Kind::kCrank ? cranks : stops;
  past.push_back(event);
  // Charges are compared over two durations.
  if (past.size() > (is_charge ? 2 : 1) * kMost) past.erase(past.begin());
}

ErrorForecast EventHistory::nextStop(double usual_error) const {
  constexpr double kNoise = kStopNoise * kStopNoise;
  double mean = 0.0, variance = usual_error * usual_error;
  double count = kGuessedStops, squares = count * (variance + kNoise);
  for (const PastEvent& stop : stops) {
    const double gain = variance / (variance + kNoise);
    const double innovation = stop.measured - stop.modelled - mean;
    mean += gain * innovation;
    variance = (1.0 - gain) * variance + kStopWalk * kStopWalk;
    squares = kKept * squares + innovation * innovation;
    count = kKept * count + 1.0;
  }
  return {mean, stops.empty() ? variance : squares / count};
}

void EventHistory::moveBy(double moved) {
  for (auto* past : {&cranks, &charges, &stops})
    for (PastEvent& event : *past) event.time += moved;
}

std::string toString(FitStatus status) {
  constexpr std::array kNames = {"converged",   "iteration_limit", "stalled", "window_too_short",
                                 "not_excited", "implausible",     "refused"};
  return kNames.at(static_cast<std::size_t>(status));
}

double capacityFor(const Fit& fit, std::optional<double> given) {
  return nominalCapacity(given ? given : fit.nominal_capacity);
}

bool isUsable(const Fit& fit) {
  const bool is_fitted = fit.window.samples > 0;
  return fit.status == FitStatus::kConverged ||
         (fit.status == FitStatus::kIterationLimit && !is_fitted);
}

BatteryModel compositionOf(const Fit& fit) { return BatteryModel(fit.effects, fit.discrepancy); }

ModelPoint pointOf(const FittedModel& model) {
  const BatteryModel composition = compositionOf(model.fit);
  ModelPoint point;
  point.parameters = composition.typicalParameters();
  const BaseParameters& base = model.fit.parameters;
  point.parameters.head<kBaseRows>() << base.r_discharge, base.r_charge, base.c2, base.beta,
      base.u_dc;
  for (Eigen::Index j = kBaseRows; j < point.parameters.size(); ++j)
    if (static_cast<std::size_t>(j) < model.fit.estimates.size())
      point.parameters[j] = model.fit.estimates[static_cast<std::size_t>(j)].value;
  point.state = composition.restState();
  point.state.head(model.state.states.size()) = model.state.states;
  point.time = model.state.time;
  point.reference_time = model.fit.window.from;
  point.regressor_memory = model.state.regressor_memory;
  return point;
}

Eigen::MatrixXd covarianceFactor(const Eigen::MatrixXd& covariance) {
  // Scaled to correlations first: the rows have different units.
  const Eigen::VectorXd std = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse = std.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const auto eigen = eigenDecomposition(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  const Eigen::VectorXd& values = eigen.eigenvalues();  // increasing
  const Eigen::Index size = values.size();
  Eigen::Index kept = 0;
  while (kept < std::min(size, Simulation::kMaxTangents) && values[size - 1 - kept] > 1e-10) ++kept;
  Eigen::MatrixXd factor(size, kept);
  for (Eigen::Index k = 0; k < kept; ++k)
    factor.col(k) =
        std.cwiseProduct(eigen.eigenvectors().col(size - 1 - k)) * std::sqrt(values[size - 1 - k]);
  return factor;
}

FittedModel atFirstState(FittedModel model, double current) {
  model.state.time = model.fit.window.from;
  model.state.current = current;
  model.state.states = model.fit.first_state;
  return model;
}

Simulation simulationOf(const FittedModel& model) {
  return Simulation(compositionOf(model.fit), pointOf(model));
}

Simulation uncertainSimulationOf(const FittedModel& model) {
  return Simulation(compositionOf(model.fit), pointOf(model),
                    covarianceFactor(model.fit.covariance));
}

FittedModel rested(FittedModel model) {
  const BatteryModel composition = compositionOf(model.fit);
  std::vector<double> memory;
  if (model.fit.discrepancy)
    memory = restedMemory(*model.fit.discrepancy, model.state.regressor_memory);
  model.state = {model.state.time, 0.0, composition.restState(), model.state.residual_state,
                 memory};
  model.state.residual_state.present.current.reset();
  const Eigen::Index states = composition.stateCount();
  model.fit.covariance.bottomRows(states).setZero();
  model.fit.covariance.rightCols(states).setZero();
  return model;
}

void takeState(FittedModel& model, const Simulation& simulation, double current) {
  model.state = {simulation.time(), current, simulation.state(), model.state.residual_state,
                 simulation.regressorMemory()};
  if (simulation.tangents() == 0) return;
  const Eigen::Index states = model.state.states.size(),
                     parameters = model.fit.covariance.rows() - states;
  const Eigen::MatrixXd& factor = simulation.seeds();
  Eigen::MatrixXd now(factor.rows(), factor.cols());
  now.topRows(parameters) = factor.topRows(parameters);
  now.bottomRows(states) = simulation.stateDerivatives();
  model.fit.covariance = now * now.transpose();
}

}  // namespace battery_sof
