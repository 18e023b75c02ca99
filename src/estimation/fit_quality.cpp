#include "estimation/fit_quality.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "estimation/window.hpp"
#include "state/posterior.hpp"
#include "util/eigen_decomposition.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kMostMeans = 200;  // that noise is fitted to
constexpr std::size_t kFewestMeans = 30;
constexpr double kTypicalNoise = 0.01;  // [V], of what fitNoise() is made for
constexpr Eigen::Index kBlock = 256;    // rows that stay in the first-level cache

using Values = Eigen::Map<const Eigen::ArrayXd>;

Values allOf(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

Eigen::ArrayXd errorOf(const std::vector<double>& measured, const std::vector<double>& predicted) {
  if (measured.size() != predicted.size() || measured.empty())
    throw std::invalid_argument(
        format("measured has %zu samples, predicted %zu: expected the same number, at least one",
               measured.size(), predicted.size()));
  return allOf(measured) - allOf(predicted);
}

/// qDyn() of what is measured [V]. @param squares sum of the squared errors [V^2].
std::optional<double> explained(const Values& measured, double squares) {
  const double mean = measured.mean();
  const double variation = (measured - mean).square().sum();
  // Rounding of the mean alone leaves about (1e-15 u)^2 a sample.
  if (variation <= 1e-26 * static_cast<double>(measured.size()) * (1.0 + mean * mean))
    return std::nullopt;
  return 100.0 * (1.0 - std::sqrt(squares / variation));
}

/// The noise of a residual by means over neighbouring rows that have weight; none of too few.
/// @param deviation RMS of these rows: fitNoise() takes the residual for one of kTypicalNoise.
std::optional<NoiseModel> noiseOf(const Eigen::VectorXd& residual, const Eigen::VectorXd& weight,
                                  const Eigen::VectorXd& time, double deviation) {
  const double unit = deviation / kTypicalNoise;
  const auto rows = static_cast<std::size_t>(residual.size());
  std::vector<std::optional<double>> values(rows);
  for (std::size_t n = 0; n < rows; ++n)
    if (weight[n] > 0.0) values[n] = residual[n] / unit;
  std::optional<NoiseModel> noise =
      fitNoiseToMeans(time, values, std::max<std::size_t>(1, rows / kMostMeans), kFewestMeans);
  if (noise)
    for (double* part : {&noise->white_std, &noise->ar_std, &noise->walk_std}) *part *= unit;
  return noise;
}

/// J'W^2 S W^2J of noise with a memory, in one pass from the last row.
Eigen::MatrixXd ofMemory(const Eigen::Ref<const Eigen::MatrixXd>& jacobian,
                         const Eigen::VectorXd& weight, const Eigen::VectorXd& time,
                         const NoiseModel& noise) {
  const Eigen::Index p = jacobian.cols();
  Eigen::MatrixXd of_ar = Eigen::MatrixXd::Zero(p, p), of_walk = of_ar;
  // Sums over the later rows, in of_ar each less what is forgotten until then.
  Eigen::RowVectorXd remembered = Eigen::RowVectorXd::Zero(p), later = remembered;
  for (Eigen::Index k = jacobian.rows(); k-- > 0;) {
    const Eigen::RowVectorXd g = weight[k] * jacobian.row(k);
    of_ar.noalias() += g.transpose() * (remembered + g);
    of_ar.noalias() += remembered.transpose() * g;
    later += g;
    const double duration = k > 0 ? time[k] - time[k - 1] : 0.0;
    remembered = (remembered + g) * std::exp(-duration / noise.ar_time);
    of_walk.noalias() += duration * later.transpose() * later;
  }
  return noise.ar_std * noise.ar_std * of_ar + noise.walk_std * noise.walk_std * of_walk;
}

}  // namespace

std::optional<double> qDyn(const std::vector<double>& measured,
                           const std::vector<double>& predicted) {
  return explained(allOf(measured), errorOf(measured, predicted).square().sum());
}

double rootMeanSquareError(const std::vector<double>& measured,
                           const std::vector<double>& predicted) {
  return std::sqrt(errorOf(measured, predicted).square().mean());
}

double AnswerErrors::rms() const {
  return samples() > 0 ? std::sqrt(squares_ / static_cast<double>(samples())) : 0.0;
}

std::optional<double> AnswerErrors::relative() const {
  const double variance = measured_.variance();
  if (!is_predicted_ || !isJudged() || !(variance > 0.0)) return std::nullopt;
  return squares_ / variance;
}

std::optional<double> explainedPercent(const std::vector<AnswerErrors>& quantities) {
  double squares = 0.0, samples = 0.0;
  for (const AnswerErrors& errors : quantities) {
    const std::optional<double> relative = errors.relative();
    if (!relative) continue;
    squares += *relative;
    samples += static_cast<double>(errors.samples());
  }
  if (samples == 0.0) return std::nullopt;
  return 100.0 * (1.0 - std::sqrt(squares / samples));
}

FittedModel unfitted(const Series& series, IndexRange range, const BatteryModel& composition,
                     FitStatus status, const std::string& message,
                     const std::optional<ExcitedRange>& excited) {
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
    model.state = {model.fit.window.to, series.current[range.last - 1]};
    model.fit.excited = excited ? *excited : excitedRange(series, range);
  }
  for (const ParameterInfo& info : composition.parameters())
    model.fit.estimates.push_back(
        {info.name, info.unit, info.magnitude, std::nullopt, false, false, info.held});
  model.state.states = composition.restState();
  return model;
}

FittedModel modelOf(const Series& series, IndexRange range, const BatteryModel& composition,
                    const CompositionFit& fit, const std::optional<ExcitedRange>& excited) {
  FittedModel model = unfitted(series, range, composition, fit.status, "", excited);
  model.fit.parameters = baseParameters(fit.point.parameters);
  model.fit.first_state = fit.point.state;
  model.fit.iterations = fit.iterations;
  std::vector<ParameterEstimate>& estimates = model.fit.estimates;
  for (std::size_t j = 0; j < estimates.size(); ++j) {
    estimates[j].value = fit.point.parameters[j];
    estimates[j].determined = estimates[j].held;
  }
  return model;
}

FitScores scoresOf(const Series& series, IndexRange range, const Eigen::VectorXd& residual,
                   double rho, const CrankLimits& limits) {
  FitScores scores;
  scores.q_dyn_percent =
      explained({series.voltage.data() + range.first, static_cast<Eigen::Index>(range.size())},
                residual.squaredNorm())
          .value_or(0.0);
  scores.rmse = std::sqrt(residual.squaredNorm() / static_cast<double>(range.size()));
  scores.residual_correlation_time = medianInterval(series) * (1.0 + rho) / (1.0 - rho);
  double squares = 0.0;
  for (const Event& crank : detectCranks(series, range, EventLimits{limits.current})) {
    double modelled = std::numeric_limits<double>::infinity();
    for (std::size_t n = crank.range.first; n < crank.range.last; ++n)
      modelled = std::min(modelled, series.voltage[n] - residual[n - range.first]);
    const bool is_bound =
        limits.sensor_min_current && crank.peak_current <= *limits.sensor_min_current;
    if (is_bound && crank.min_voltage <= modelled) continue;
    squares += std::pow(crank.min_voltage - modelled, 2);
    ++scores.cranks;
  }
  scores.crank_error_std = scores.cranks > 0 ? std::sqrt(squares / scores.cranks) : scores.rmse;
  return scores;
}

void conclude(Fit& fit) {
  takeStandardErrors(fit);
  const std::size_t u_dc = kRowUDc;
  bool knows_anything = false;
  for (std::size_t j = 0; j < fit.estimates.size(); ++j)
    knows_anything |= j != u_dc && fit.estimates[j].determined && !fit.estimates[j].held;
  if (!knows_anything) fit.status = FitStatus::kNotExcited;
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
  fit.message = weak.empty() ? text : text + "; the window does not determine " + join(weak);
}

void requirePlausible(Fit& fit) {
  constexpr double kLeast = 1e-6;  // of determinedBelow()
  constexpr double kUsual = 1e-3;  // [V], of what a fit leaves
  if (!isUsable(fit)) return;
  const double least = kLeast * std::min(1.0, fit.scores.rmse / kUsual);
  std::string why;
  if (fit.iterations == 0)
    why = "the search did not move from its start, so the window determined nothing";
  for (std::size_t j = 0; j < fit.estimates.size() && why.empty(); ++j) {
    const ParameterEstimate& estimate = fit.estimates[j];
    if (estimate.std && *estimate.std < least * determinedBelow(fit, j))
      why = format(
          "the fit failed: the standard error of %s, %.2g %s, is smaller than %zu samples with an "
          "error of %.3g mV RMS can give",
          estimate.name.c_str(), *estimate.std, estimate.unit.c_str(), fit.window.samples,
          1e3 * fit.scores.rmse);
  }
  if (why.empty()) return;
  fit.status = FitStatus::kImplausible;
  fit.message = why;
}

double lagOneCorrelation(const Eigen::VectorXd& residual) {
  const Eigen::Index n = residual.size();
  if (n < 3) return 0.0;
  const Eigen::VectorXd e = residual.array() - residual.mean();
  const double power = e.squaredNorm();
  return power > 0.0 ? std::clamp(e.head(n - 1).dot(e.tail(n - 1)) / power, -0.9999, 0.9999) : 0.0;
}

Sandwich sandwichParts(const Eigen::Ref<const Eigen::MatrixXd>& jacobian,
                       const Eigen::VectorXd& residual, const Eigen::VectorXd& weight,
                       const Eigen::VectorXd& time) {
  const Eigen::Index n = jacobian.rows(), p = jacobian.cols();
  Sandwich parts{Eigen::MatrixXd::Zero(p, p), Eigen::MatrixXd::Zero(p, p)};
  for (Eigen::Index first = 0; first < n; first += kBlock) {
    const Eigen::Index rows = std::min(kBlock, n - first);
    const auto J = jacobian.middleRows(first, rows);
    const auto w = weight.segment(first, rows), e = residual.segment(first, rows);
    parts.A.noalias() += J.transpose() * (w.asDiagonal() * J);
    parts.B.noalias() += J.transpose() * (w.cwiseProduct(e).cwiseAbs2().asDiagonal() * J);
  }
  const double counted = (weight.array() > 0.0).cast<double>().sum();
  const double variance =
      (weight.array() > 0.0).select(residual.array().square(), 0.0).sum() / counted;
  if (!(variance > 0.0)) return parts;
  const auto noise = noiseOf(residual, weight, time, std::sqrt(variance));
  if (!noise) return parts;
  parts.B *= std::max(1.0, noise->white_std * noise->white_std / variance);
  parts.B += ofMemory(jacobian, weight, time, *noise);
  return parts;
}

Eigen::MatrixXd informationInverse(const Eigen::MatrixXd& A) {
  const Eigen::VectorXd scale =
      A.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
  const auto eigen = eigenDecomposition(scale.asDiagonal() * A * scale.asDiagonal());
  const double floor = 1e-12 * std::max(eigen.eigenvalues().maxCoeff(), 1e-300);
  const Eigen::VectorXd inverse = eigen.eigenvalues().unaryExpr(
      [floor](double value) { return value > floor ? 1.0 / value : 0.0; });
  return scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() *
         eigen.eigenvectors().transpose() * scale.asDiagonal();
}

Eigen::MatrixXd combined(const Sandwich& parts) {
  const Eigen::MatrixXd A_inverse = informationInverse(parts.A);
  return A_inverse * parts.B * A_inverse;
}

}  // namespace battery_sof
