#include "diagnosis/whitened_fit.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace battery_sof {
namespace {

// A column that the others explain but for this share of its length adds nothing (condition of J in
// double precision).
constexpr double kDependent = 1e-7;

Eigen::MatrixXd orthonormalColumns(Eigen::MatrixXd columns) {
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const double length = columns.col(k).norm();
    if (length > 0.0) columns.col(k) /= length;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  qr.setThreshold(kDependent);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(columns.rows(), qr.rank());
  basis.applyOnTheLeft(qr.householderQ());
  return basis;
}

// of an edge: where the resistance changes from one value to the other
constexpr double kCrossing = 0.2;

bool isEdge(double from, double to, double edge) {
  const double change = std::abs(to - from);
  return change > edge || (from * to < 0.0 && change > kCrossing * edge);
}

}  // namespace

WhitenedFit fitWhitened(const BatteryModel& model, const InputSequence& inputs,
                        const std::vector<CompositionPoint>& starts,
                        const std::optional<NoiseModel>& noise, const WhitenedSearch& search) {
  FitCost cost;
  cost.crank_weight = 1.0;
  cost.known = knownOf(search.priors, model.effects());
  CompositionSearch plain = search;
  std::vector<CompositionPoint> from = starts;
  cost.noise = noise;
  if (!noise) {
    const CompositionProblem squares(model, inputs, cost, starts.front());
    from = {fitComposition(squares, starts, plain).point};
    cost.noise = fitNoise(squares.residual(squares.coordinatesOf(from.front())), inputs.samples,
                          search.min_white);
    plain.more_starts = 0;
  }
  WhitenedFit fit;
  fit.model = model;
  fit.known = cost.known;
  for (int round = 0; round < search.rounds; ++round) {
    const CompositionProblem problem(model, inputs, cost, starts.front());
    const CompositionFit found = fitComposition(problem, from, plain);
    fit.point = found.point;
    fit.noise = fitNoise(problem.residual(found.x), inputs.samples, search.min_white);
    cost.noise = fit.noise;
    from = {found.point};
    plain.more_starts = 0;
  }
  const CompositionProblem problem(model, inputs, cost, fit.point);
  const Eigen::VectorXd x = problem.coordinatesOf(fit.point);
  const ModelPass pass = passOver(model, inputs, fit.point, problem.seedsAt(x));
  fit.jacobian = pass.jacobian;
  fit.residual = pass.residual;
  for (std::size_t n = 0; n < inputs.samples.size(); ++n)
    if (!(inputs.samples[n].count > 0.0)) fit.residual[n] = 0.0;
  fit.innovation = whitened(fit, inputs, fit.residual);
  fit.biased = orthonormalColumns(whitened(fit, inputs, fit.jacobian));
  for (Eigen::Index k = 0; k < problem.size(); ++k) fit.rows.push_back(problem.rowOf(k));
  NormalEquations at;
  problem.evaluate(x, at);
  const double priors = std::max(0.0, at.cost - fit.innovation.squaredNorm());
  fit.deviance = deviance(fit.noise, fit.residual, inputs.samples) + priors;
  return fit;
}

Eigen::MatrixXd whitened(const WhitenedFit& fit, const InputSequence& inputs,
                         Eigen::MatrixXd columns) {
  const Whitening whitening(fit.noise, inputs.samples);
  for (auto column : columns.colwise()) column = whitening.whitened(column);
  return columns;
}

InputSequence withoutEdges(const InputSequence& inputs, double edge, double before, double after) {
  InputSequence quiet = inputs;
  std::size_t first = 0;
  for (std::size_t n = 0; n < quiet.samples.size(); ++n) {
    const double time = quiet.samples[n].step.time;
    const bool begins = n == 0 || quiet.samples[n].step.gap;
    if (!begins && !isEdge(quiet.samples[n - 1].step.current, quiet.samples[n].step.current, edge))
      continue;
    while (quiet.samples[first].step.time < time - before) ++first;
    for (std::size_t k = first;
         k < quiet.samples.size() && quiet.samples[k].step.time <= time + after; ++k)
      quiet.samples[k].count = 0.0;
  }
  return quiet;
}

Eigen::VectorXd simulatedVoltage(const BatteryModel& model, const CompositionPoint& point,
                                 const InputSequence& inputs) {
  Simulation simulation(model, point.at(inputs.first_time));
  Eigen::VectorXd voltage(inputs.samples.size());
  for (Eigen::Index n = 0; n < voltage.size(); ++n) {
    simulation.advance(inputs.samples[n].step);
    voltage[n] = simulation.voltage();
  }
  return voltage;
}

Signatures signaturesOf(const WhitenedFit& fit, const InputSequence& inputs,
                        Eigen::MatrixXd columns) {
  Signatures signatures;
  signatures.columns = whitened(fit, inputs, std::move(columns));
  signatures.length = signatures.columns.colwise().norm();
  const Eigen::MatrixXd biased = fit.biased.transpose() * signatures.columns;
  signatures.columns.noalias() -= fit.biased * biased;
  return signatures;
}

}  // namespace battery_sof
