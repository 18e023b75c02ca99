#include "estimation/fit_quality.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "estimation/window.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

using Values = Eigen::Map<const Eigen::ArrayXd>;

Values allOf(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

Eigen::ArrayXd errorOf(const std::vector<double>& measured, const std::vector<double>& predicted) {
  if (measured.size() != predicted.size() || measured.empty())
    throw std::invalid_argument("measured has " + std::to_string(measured.size()) +
                                " samples, predicted " + std::to_string(predicted.size()) +
                                ": expected the same number, at least one");
  return allOf(measured) - allOf(predicted);
}

}  // namespace

std::optional<double> qDyn(const std::vector<double>& measured,
                           const std::vector<double>& predicted) {
  return qDyn(allOf(measured), errorOf(measured, predicted).square().sum());
}

std::optional<double> qDyn(const Eigen::Map<const Eigen::ArrayXd>& measured, double squares) {
  const double mean = measured.mean();
  const double variation = (measured - mean).square().sum();
  // Rounding of the mean alone leaves about (1e-15 u)^2 a sample.
  if (variation <= 1e-26 * static_cast<double>(measured.size()) * (1.0 + mean * mean))
    return std::nullopt;
  return 100.0 * (1.0 - std::sqrt(squares / variation));
}

double rootMeanSquareError(const std::vector<double>& measured,
                           const std::vector<double>& predicted) {
  return std::sqrt(errorOf(measured, predicted).square().mean());
}

std::optional<double> standardError(const Eigen::MatrixXd& covariance, Eigen::Index row) {
  const double variance = covariance(row, row);
  return variance > 0.0 && std::isfinite(variance) ? std::optional(std::sqrt(variance))
                                                   : std::nullopt;
}

FittedModel unfitted(const Series& series, IndexRange range, const BatteryModel& composition,
                     FitStatus status, const std::string& message) {
  return unfitted(series, range, excitedRange(series, range), composition, status, message);
}

FittedModel unfitted(const Series& series, IndexRange range, const ExcitedRange& excited,
                     const BatteryModel& composition, FitStatus status,
                     const std::string& message) {
  FittedModel model;
  model.fit.effects = composition.effects();
  model.fit.discrepancy = composition.discrepancy();
  model.fit.status = status;
  model.fit.message = message;
  const Eigen::Index rows = composition.parameterCount() + composition.stateCount();
  model.fit.covariance = Eigen::MatrixXd::Zero(rows, rows);
  model.fit.window.samples = range.size();
  if (!range.empty()) {
    model.fit.window.from = series.time[range.first];
    model.fit.window.to = series.time[range.last - 1];
    model.state = {model.fit.window.to, 0.0, series.current[range.last - 1]};
    model.fit.excited = excited;
  }
  for (const ParameterInfo& info : composition.parameters())
    model.fit.estimates.push_back(
        {info.name, info.unit, info.magnitude, std::nullopt, false, false, info.held});
  const Eigen::VectorXd rest = composition.restState();
  model.state.further.assign(rest.data() + 1, rest.data() + rest.size());
  return model;
}

FitScores scoresOf(const Series& series, IndexRange range, const Eigen::VectorXd& residual,
                   double rho, double crank_current) {
  FitScores scores;
  scores.q_dyn_percent =
      qDyn({series.voltage.data() + range.first, static_cast<Eigen::Index>(range.size())},
           residual.squaredNorm())
          .value_or(0.0);
  scores.rmse = std::sqrt(residual.squaredNorm() / static_cast<double>(range.size()));
  scores.residual_correlation_time = medianInterval(series) * (1.0 + rho) / (1.0 - rho);
  EventLimits limits;
  limits.crank_current = crank_current;
  double squares = 0.0;
  for (const Event& crank :
       detectCranks(series, range, limits, gapThreshold(medianInterval(series.time, range)))) {
    double modelled = std::numeric_limits<double>::infinity();
    for (std::size_t n = crank.range.first; n < crank.range.last; ++n)
      modelled = std::min(modelled,
                          series.voltage[n] - residual[static_cast<Eigen::Index>(n - range.first)]);
    squares += std::pow(crank.min_voltage - modelled, 2);
    ++scores.cranks;
  }
  scores.crank_error_std = scores.cranks > 0 ? std::sqrt(squares / scores.cranks) : scores.rmse;
  return scores;
}

std::string sentenceOf(const Fit& fit) {
  std::string text = "no step lowers the cost any more, but the optimum was not reached";
  if (fit.status == FitStatus::kConverged)
    text = format("converged after %d iterations", fit.iterations);
  if (fit.status == FitStatus::kIterationLimit)
    text = format("stopped by the limit of %d iterations", fit.iterations);
  if (fit.status == FitStatus::kNotExcited) text = "the window determines none of the parameters";
  std::vector<std::string> weak;
  for (const auto& estimate : fit.estimates)
    if (!estimate.determined && !estimate.held)
      weak.push_back(estimate.name + (estimate.at_bound ? " (at a bound)" : ""));
  return weak.empty() ? text : text + "; the window does not determine " + join(weak);
}

}  // namespace battery_sof
