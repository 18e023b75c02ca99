#include "estimation/fit_description.hpp"

#include <algorithm>
#include <cmath>

#include "estimation/fit_quality.hpp"
#include "estimation/window.hpp"
#include "recording/sampling.hpp"
#include "util/number_text.hpp"

namespace battery_sof {

FitStatus fitStatusOf(MinimizeStatus status) {
  switch (status) {
    case MinimizeStatus::kConverged: return FitStatus::kConverged;
    case MinimizeStatus::kIterationLimit: return FitStatus::kIterationLimit;
    case MinimizeStatus::kStalled: return FitStatus::kStalled;
  }
  return FitStatus::kStalled;
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
  EventLimits limits;
  limits.crank_current = crank_current;
  const double max_gap = gapThreshold(medianInterval(series.time, range));
  const auto residualAt = [&](std::size_t n) { return residual[static_cast<Eigen::Index>(n)]; };
  return scoresOf(
      series, range,
      {residual.squaredNorm(), rho,
       crankErrors(series, range.first, detectCranks(series, range, limits, max_gap), residualAt)},
      medianInterval(series));
}

FitScores scoresOf(const Series& series, IndexRange range, const FitErrors& errors,
                   double interval) {
  const double count = static_cast<double>(range.size());
  FitScores scores;
  scores.q_dyn_percent =
      qDyn({series.voltage.data() + range.first, static_cast<Eigen::Index>(range.size())},
           errors.squares)
          .value_or(0.0);
  scores.rmse = std::sqrt(errors.squares / count);
  scores.cranks = static_cast<int>(errors.cranks.size());
  double squares = 0.0;
  for (const double error : errors.cranks) squares += error * error;
  scores.crank_error_std = scores.cranks > 0 ? std::sqrt(squares / scores.cranks) : scores.rmse;
  scores.residual_correlation_time = interval * (1.0 + errors.rho) / (1.0 - errors.rho);
  return scores;
}

std::string sentenceOf(const Fit& fit) {
  ClassicStream text;
  switch (fit.status) {
    case FitStatus::kConverged:
      text << "converged after " << fit.iterations << " iterations";
      break;
    case FitStatus::kIterationLimit:
      text << "stopped by the limit of " << fit.iterations << " iterations";
      break;
    case FitStatus::kNotExcited: text << "the window determines none of the parameters"; break;
    default: text << "no step lowers the cost any more, but the optimum was not reached"; break;
  }
  std::string weak;
  for (const auto& estimate : fit.estimates) {
    if (estimate.determined || estimate.held) continue;
    weak += (weak.empty() ? "" : ", ") + estimate.name + (estimate.at_bound ? " (at a bound)" : "");
  }
  if (!weak.empty()) text << "; the window does not determine " << weak;
  return text.str();
}

}  // namespace battery_sof
