#include "battery_sof/identify/fit_description.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <tuple>

#include "battery_sof/identify/fit_quality.hpp"
#include "battery_sof/identify/window.hpp"
#include "battery_sof/recording/events.hpp"

namespace battery_sof {

FitStatus fitStatusOf(MinimizeStatus status) {
  switch (status) {
    case MinimizeStatus::kConverged:
      return FitStatus::kConverged;
    case MinimizeStatus::kIterationLimit:
      return FitStatus::kIterationLimit;
    case MinimizeStatus::kStalled:
      return FitStatus::kStalled;
  }
  return FitStatus::kStalled;
}

std::optional<double> standardError(const Eigen::MatrixXd& covariance, Eigen::Index row) {
  const double variance = covariance(row, row);
  return variance > 0.0 && std::isfinite(variance) ? std::optional(std::sqrt(variance)) : std::nullopt;
}

FittedModel unfitted(const Series& series, IndexRange range, const std::vector<std::string>& effects,
                     FitStatus status, const std::string& message) {
  const BatteryModel composition(effects);
  FittedModel model;
  model.effects = composition.effects();
  model.status = status;
  model.message = message;
  const Eigen::Index rows = composition.parameterCount() + composition.stateCount();
  model.covariance = Eigen::MatrixXd::Zero(rows, rows);
  model.window.samples = range.size();
  if (!range.empty()) {
    model.window.from = series.time[range.first];
    model.window.to = series.time[range.last - 1];
    model.state = {model.window.to, 0.0, series.current[range.last - 1]};
    model.excited = excitedRange(series, range);
  }
  for (const ParameterInfo& info : composition.parameters())
    model.estimates.push_back(
        {info.name, info.unit, info.magnitude, std::nullopt, false, false, info.held});
  const Eigen::VectorXd rest = composition.restState();
  model.state.further.assign(rest.data() + 1, rest.data() + rest.size());
  return model;
}

namespace {

/// RMS difference of the cranks' measured and modelled minima [V], and their number.
std::pair<double, int> crankErrors(const Series& series, IndexRange range,
                                   const std::vector<double>& modelled, double crank_current) {
  EventLimits limits;
  limits.crank_current = crank_current;
  double sum = 0.0;
  int cranks = 0;
  for (const Event& event : detectEvents(slice(series, range), limits)) {
    if (event.kind != EventKind::kCrank) continue;
    const auto first = modelled.begin() + static_cast<std::ptrdiff_t>(event.range.first);
    const auto last = modelled.begin() + static_cast<std::ptrdiff_t>(event.range.last);
    const double error = event.min_voltage - *std::min_element(first, last);
    sum += error * error;
    ++cranks;
  }
  return {cranks > 0 ? std::sqrt(sum / cranks) : 0.0, cranks};
}

}  // namespace

FitScores scoresOf(const Series& series, IndexRange range, const Eigen::VectorXd& residual,
                   double rho, double crank_current) {
  const auto begin = series.voltage.begin();
  const std::vector<double> measured(begin + static_cast<std::ptrdiff_t>(range.first),
                                     begin + static_cast<std::ptrdiff_t>(range.last));
  std::vector<double> modelled(measured);
  for (std::size_t n = 0; n < modelled.size(); ++n) modelled[n] -= residual[n];
  FitScores scores;
  scores.q_dyn_percent = qDyn(measured, modelled).value_or(0.0);
  scores.rmse = rootMeanSquareError(measured, modelled);
  std::tie(scores.crank_error_std, scores.cranks) =
      crankErrors(series, range, modelled, crank_current);
  if (scores.cranks == 0) scores.crank_error_std = scores.rmse;
  scores.residual_correlation_time = medianInterval(series) * (1.0 + rho) / (1.0 - rho);
  return scores;
}

std::string sentenceOf(const FittedModel& model) {
  std::ostringstream text;
  switch (model.status) {
    case FitStatus::kConverged:
      text << "converged after " << model.iterations << " iterations";
      break;
    case FitStatus::kIterationLimit:
      text << "stopped by the limit of " << model.iterations << " iterations";
      break;
    case FitStatus::kNotExcited:
      text << "the window determines none of the parameters";
      break;
    default:
      text << "no step lowers the cost any more, but the optimum was not reached";
      break;
  }
  std::string weak;
  for (const auto& estimate : model.estimates) {
    if (estimate.determined || estimate.held) continue;
    weak += (weak.empty() ? "" : ", ") + estimate.name + (estimate.at_bound ? " (at a bound)" : "");
  }
  if (!weak.empty()) text << "; the window does not determine " << weak;
  return text.str();
}

}  // namespace battery_sof
