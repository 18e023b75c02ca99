#include "state/noise_model.hpp"

#include <cmath>
#include <stdexcept>
#include <unsupported/Eigen/AutoDiff>

#include "regression/levenberg_marquardt.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kMinSamples = 30;

void requireSound(const NoiseModel& noise) {
  constexpr char kAbove[] = "a finite value above 0", kAtLeast[] = "a finite value, at least 0";
  requireThat(noise.white_std > 0.0, "white_std [V]", noise.white_std, kAbove);
  requireThat(noise.ar_std >= 0.0, "ar_std [V]", noise.ar_std, kAtLeast);
  requireThat(noise.ar_time > 0.0, "ar_time [s]", noise.ar_time, kAbove);
  requireThat(noise.walk_std >= 0.0, "walk_std [V/sqrt(s)]", noise.walk_std, kAtLeast);
}

using Four = Eigen::AutoDiffScalar<Eigen::Vector4d>;

/// The deviance with its slope and expected curvature to the logarithms of white_std, ar_std,
/// ar_time, walk_std.
void evaluateDeviance(const Eigen::Vector4d& logs, const Eigen::VectorXd& residual,
                      const std::vector<InputSample>& samples, NormalEquations& equations) {
  const auto variable = [&](int j, double factor) {
    using std::exp;
    return Four(std::exp(factor * logs[j]),
                factor * std::exp(factor * logs[j]) * Eigen::Vector4d::Unit(j));
  };
  NoiseFilter<Four> filter(variable(0, 2.0), variable(1, 2.0), variable(2, 1.0), variable(3, 2.0));
  Four d(0.0), a(0.0);
  double cost = 0.0;
  Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
  Eigen::Matrix4d curvature = Eigen::Matrix4d::Zero();
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if (samples[n].count <= 0.0) {
      a = Four(a * filter.wait(samples[n].step.duration));
      continue;
    }
    const auto step = filter.step(samples[n].step.duration, samples[n].count, n == 0);
    a = Four(a * step.persistence);
    const Four v = Four(residual[static_cast<Eigen::Index>(n)] - d - a);
    d = Four(d + step.drift * v);
    a = Four(a + step.colored * v);
    const double S = step.variance.value();
    const Eigen::Vector4d dS = step.variance.derivatives() / S;
    const Eigen::Vector4d& dv = v.derivatives();
    cost += std::log(S) + v.value() * v.value() / S;
    // Halves, because minimize() takes J'r and J'J of a sum of squares.
    gradient += 0.5 * dS * (1.0 - v.value() * v.value() / S) + dv * (v.value() / S);
    curvature += 0.25 * dS * dS.transpose() + dv * dv.transpose() / S;
  }
  equations = {cost, gradient, curvature};
}

}  // namespace

Whitening::Whitening(const NoiseModel& noise, const std::vector<InputSample>& samples) {
  requireSound(noise);
  NoiseFilter<double> filter = filterOf(noise);
  gains_.reserve(samples.size());
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if (samples[n].count <= 0.0) {
      gains_.push_back({filter.wait(samples[n].step.duration), 0.0, 0.0, 0.0});
      continue;
    }
    const auto step = filter.step(samples[n].step.duration, samples[n].count, n == 0);
    gains_.push_back({step.persistence, step.drift, step.colored, 1.0 / std::sqrt(step.variance)});
    log_determinant_ -= 2.0 * std::log(gains_.back().scale);
  }
}

Eigen::VectorXd Whitening::whitened(const Eigen::VectorXd& column) const {
  Eigen::VectorXd out(column.size());
  Memory<double> memory{0.0, 0.0};
  for (Eigen::Index n = 0; n < column.size(); ++n) {
    double value = column[n];
    apply(static_cast<std::size_t>(n), value, memory);
    out[n] = value;
  }
  return out;
}

double deviance(const NoiseModel& noise, const Eigen::VectorXd& residual,
                const std::vector<InputSample>& samples) {
  const Whitening whitening(noise, samples);
  return whitening.logDeterminant() + whitening.whitened(residual).squaredNorm();
}

NoiseModel fitNoise(const Eigen::VectorXd& residual, const std::vector<InputSample>& samples,
                    double min_white) {
  if (static_cast<std::size_t>(residual.size()) != samples.size() || samples.size() < kMinSamples)
    throw std::invalid_argument(
        format("fitNoise: %td residuals for %zu samples, expected as many and at least %zu",
               residual.size(), samples.size(), kMinSamples));
  const double rms = std::max(
      std::sqrt(residual.squaredNorm() / static_cast<double>(residual.size())), 2.0 * min_white);
  // The four numbers change the deviance, which may be negative; minimize() needs a cost above
  // zero.
  double shift = 0.0;
  const auto evaluate = [&](const Eigen::VectorXd& logs, NormalEquations& equations) {
    evaluateDeviance(logs, residual, samples, equations);
    equations.cost += shift;
    return std::isfinite(equations.cost) && equations.gradient.allFinite() &&
           equations.hessian.allFinite();
  };
  MinimizeOptions options;
  options.max_iterations = 60;
  options.lower =
      Eigen::Vector4d(std::log(min_white), std::log(1e-6), std::log(0.1), std::log(1e-7));
  options.upper = Eigen::Vector4d(std::log(1.0), std::log(3.0), std::log(60.0), std::log(0.1));
  NoiseModel best{rms, 1e-6, 1.0, 1e-7};
  double best_cost = HUGE_VAL;
  for (const double ar_time : {1.0, 10.0}) {
    const Eigen::Vector4d start(std::log(std::max(0.5 * rms, 1.01 * min_white)),
                                std::log(0.7 * rms), std::log(ar_time), std::log(0.1 * rms));
    NormalEquations at_start;
    shift = 0.0;
    if (!evaluate(start, at_start)) continue;
    // One unit of deviance then counts as one part in the number of samples.
    shift = static_cast<double>(samples.size()) - at_start.cost;
    const MinimizeResult result = minimize(evaluate, start, options);
    const double cost = result.at.cost - shift;
    if (cost >= best_cost) continue;
    best_cost = cost;
    best = {std::exp(result.x[0]), std::exp(result.x[1]), std::exp(result.x[2]),
            std::exp(result.x[3])};
  }
  return best;
}

std::optional<NoiseModel> fitNoiseToMeans(const Eigen::Ref<const Eigen::VectorXd>& time,
                                          const std::vector<std::optional<double>>& residual,
                                          std::size_t each, std::size_t fewest) {
  std::vector<InputSample> samples;
  std::vector<double> means;
  double before = 0.0;
  std::size_t counted = 0;
  for (std::size_t first = 0; first < residual.size(); first += each) {
    const std::size_t last = std::min(first + each, residual.size());
    InputSample sample;
    sample.count = 0.0;
    double sum = 0.0, at = 0.0;
    for (std::size_t n = first; n < last; ++n) {
      at += (time[n] - time[0]) / static_cast<double>(last - first);
      if (!residual[n]) continue;
      sum += *residual[n];
      sample.count += 1.0;
    }
    sample.step.duration = std::max(0.0, at - before);
    before = at;
    samples.push_back(sample);
    means.push_back(sample.count > 0.0 ? sum / sample.count : 0.0);
    if (sample.count > 0.0) ++counted;
  }
  if (counted < fewest) return std::nullopt;
  return fitNoise(
      Eigen::Map<const Eigen::VectorXd>(means.data(), static_cast<Eigen::Index>(means.size())),
      samples);
}

}  // namespace battery_sof
