#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "estimation/identification.hpp"
#include "estimation/window.hpp"
#include "experiment.hpp"
#include "prediction/pipeline.hpp"
#include "prediction/scores.hpp"
#include "state/state_estimator.hpp"

namespace battery_sof {
namespace {

/// Standard deviation of a voltage that follows a held stop and a held event, from the fit's
/// covariance alone [V].
double eventDeviation(const FittedModel& model, double load, double stop, double current,
                      double duration) {
  Simulation simulation = uncertainSimulationOf(model);
  simulation.hold(load, stop);
  simulation.hold(current, duration);
  return simulation.voltageDerivatives().norm();
}

double logDeterminant(const Eigen::MatrixXd& covariance) {
  double sum = 0.0;
  const Eigen::Index rows = kBaseRows;
  Eigen::MatrixXd scaled = covariance.topLeftCorner(rows, rows);
  const Eigen::VectorXd unit = (Eigen::VectorXd(5) << 0.008, 0.01, 1000.0, 20.0, 1.0).finished();
  scaled = unit.cwiseInverse().asDiagonal() * scaled * unit.cwiseInverse().asDiagonal();
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled).eigenvalues();
  for (const double value : values) sum += std::log(std::max(value, 1e-20));
  return sum;
}

double worstRelative(const Fit& fit) {
  double worst = 0.0;
  for (int j = 0; j < kRowUDc; ++j) {
    const auto& e = fit.estimates[static_cast<std::size_t>(j)];
    worst = std::max(worst, e.std ? *e.std / std::abs(e.value) : 10.0);
  }
  return worst;
}

/// Q_dyn of the window's last third when its first two thirds were fitted [%].
double insideValidation(const Series& series, IndexRange window) {
  const IndexRange train{window.first, window.first + 2 * window.size() / 3};
  FittedModel model = identify(series, train);
  if (!isUsable(model.fit)) return -100.0;
  const Series part = slice(series, window);
  const IndexRange test{train.size(), part.size()};
  const PredictedVoltage predicted = predictSeries(model, part, test).voltages();
  return std::max(-100.0, scorePrediction(part, test, predicted).q_dyn_percent.value_or(-100.0));
}

struct Moments {
  double std = 0.0, lowest = 0.0, highest = 0.0;
};
Moments momentsOf(const Series& series, IndexRange range) {
  Moments m;
  double sum = 0.0, square = 0.0;
  for (std::size_t n = range.first; n < range.last; ++n) {
    sum += series.current[n];
    square += series.current[n] * series.current[n];
    m.lowest = std::min(m.lowest, series.current[n]);
    m.highest = std::max(m.highest, series.current[n]);
  }
  const double count = static_cast<double>(range.size());
  m.std = std::sqrt(std::max(0.0, square / count - sum * sum / count / count));
  return m;
}

void runWindow(const std::string& name, const Series& series, IndexRange window, IndexRange whole) {
  FittedModel model = identify(series, window);
  if (!isUsable(model.fit)) return;
  fitErrors(model, series, window);
  const PredictedVoltage predicted = predictSeries(model, series, whole).voltages();
  const PredictionScores scores = scorePrediction(series, whole, predicted);
  double crank = 0.0;
  for (const auto& c : scores.cranks)
    crank += std::abs(c.measured - c.expected.value) / static_cast<double>(scores.cranks.size());
  const Moments m = momentsOf(series, window);
  const NoiseModel noise = model.fit.noise.value_or(NoiseModel{});
  std::printf(
      "%s,%.1f,%.3f,%.4f,%zu,%.4f,%.4f,%.5f,%.5f,%.5f,%.5f,%.3f,%.5f,%.3f,%.5f,%.2f,%.1f,%.1f,%d,%."
      "6f,%.5f,%.3f,%.6f,%.1f,%.1f,%.3f,%.4f\n",
      name.c_str(), model.fit.window.from, scores.q_dyn_percent.value_or(NAN), crank,
      scores.cranks.size(), scores.rmse, windowExcitation(series, window),
      eventDeviation(model, -20.0, 30.0, -200.0, 1.0),
      eventDeviation(model, -20.0, 30.0, -20.0, 1.0),
      eventDeviation(model, -10.0, 10.0, 30.0, 10.0), eventDeviation(model, 0.0, 0.0, -200.0, 1.0),
      logDeterminant(model.fit.covariance), worstRelative(model.fit),
      model.fit.scores.q_dyn_percent, model.fit.scores.rmse, m.std, m.lowest, m.highest,
      model.fit.scores.cranks, noise.white_std, noise.ar_std, noise.ar_time, noise.walk_std,
      model.fit.excited.charge_time, model.fit.excited.discharge_time,
      insideValidation(series, window), model.fit.window_quality);
}

}  // namespace

void judgeWindows(const Recording& recording, const ExperimentOptions& o) {
  const Series& series = recording.series;
  const double length = defaultWindowLength(series);
  for (const IndexRange& part : contiguousRanges(series, gapThreshold(series))) {
    const double from = series.time[part.first], to = series.time[part.last - 1];
    if (to - from < 3.0 * length) continue;
    for (int k = 0; k < o.windows; ++k) {
      const double start = from + (to - from - length) * k / (o.windows - 1.0);
      runWindow(recording.name + "@" + std::to_string(static_cast<long>(from)), series,
                indexRange(series, start, start + length), part);
    }
  }
}

}  // namespace battery_sof
