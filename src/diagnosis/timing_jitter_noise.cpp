#include "diagnosis/timing_jitter_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "util/eigen_decomposition.hpp"

namespace battery_sof {
namespace {

// A step of 100 A: from a third of the noise (q), a thousandth of it in a second (h), on to
// hundreds of times it.
constexpr double kLeast = 1e-5, kMost = 10.0;
constexpr int kGrid = 7;                  // values a parameter, one a decade
constexpr double kMinInformation = 1e-2;  // of the noise's variance

double stepInto(const InputSequence& inputs, std::size_t n) {
  const auto& samples = inputs.samples;
  return n > 0 && n < samples.size() && !samples[n].step.gap
             ? samples[n].step.current - samples[n - 1].step.current
             : 0.0;
}

double squaredChange(const InputSequence& inputs, std::size_t n) {
  return std::pow(stepInto(inputs, n), 2) + std::pow(stepInto(inputs, n + 1), 2);
}

/// Values around one, `factor` apart, and none.
std::vector<double> around(double centre, double factor, int count) {
  std::vector<double> values = {0.0};
  for (int k = 0; k < count; ++k) values.push_back(centre * std::pow(factor, k - (count - 1) / 2));
  return values;
}

}  // namespace

TimingJitterNoise::TimingJitterNoise(const InputSequence& inputs, const Linearization& response,
                                     const std::vector<Eigen::Index>& counted) {
  if (counted.empty() || response.first[1] - response.first[0] > 1) return;
  change_.resize(counted.size());
  Step step;
  Eigen::Index row = 0;
  for (std::size_t n = 0; n < counted.size(); ++n) {
    for (; row <= counted[n]; ++row) {
      const std::size_t sample = response.first[row];
      const double kept = response.persistence[row] * (1.0 - response.yielding[row]);
      step.retained *= kept;
      step.brought = kept * kept * step.brought +
                     std::pow(stepInto(inputs, sample) * inputs.samples[sample].step.duration, 2);
    }
    steps_.push_back(step);
    step = {};
    change_[n] = squaredChange(inputs, response.first[counted[n]]);
  }
}

TimingJitterNoise TimingJitterNoise::with(double jitter, double charge) const {
  TimingJitterNoise next = *this;
  next.jitter_ = jitter;
  next.charge_ = charge;
  next.gain_.resize(change_.size());
  next.scale_.resize(change_.size());
  double spread = 0.0;  // variance of x over s^2
  for (Eigen::Index n = 0; n < change_.size(); ++n) {
    const Step& step = steps_[n];
    spread = step.retained * step.retained * spread + charge * charge * step.brought;
    const double seen = spread + 1.0 + jitter * change_[n];
    next.gain_[n] = spread / seen;
    next.scale_[n] = 1.0 / std::sqrt(seen);
    spread *= 1.0 - next.gain_[n];
  }
  return next;
}

Eigen::MatrixXd TimingJitterNoise::whitened(
    const Eigen::Ref<const Eigen::MatrixXd>& columns) const {
  if (isWhite()) return columns;
  constexpr Eigen::Index kAtOnce = 8;  // columns: every step of one waits for its last
  Eigen::MatrixXd innovations(columns.rows(), columns.cols());
  for (Eigen::Index first = 0; first < columns.cols(); first += kAtOnce) {
    const Eigen::Index count = std::min(kAtOnce, columns.cols() - first);
    std::array<double, kAtOnce> x{};
    for (Eigen::Index n = 0; n < columns.rows(); ++n)
      for (Eigen::Index k = 0; k < count; ++k) {
        double& expected = x[k];
        expected *= steps_[n].retained;
        const double left = columns(n, first + k) - expected;
        expected += gain_[n] * left;
        innovations(n, first + k) = scale_[n] * left;
      }
  }
  return innovations;
}

double TimingJitterNoise::logScale() const { return isWhite() ? 0.0 : scale_.array().log().sum(); }

TimingJitterNoise TimingJitterNoise::best(
    const std::function<double(const TimingJitterNoise&)>& evidence) const {
  TimingJitterNoise found = with(0.0, 0.0);
  if (!applies()) return found;
  double most = evidence(found);
  std::set<std::pair<double, double>> tried = {{0.0, 0.0}};
  const auto improve = [&](const std::vector<double>& candidates, bool of_charge) {
    for (const double candidate : candidates) {
      TimingJitterNoise other =
          of_charge ? with(found.jitter_, candidate) : with(candidate, found.charge_);
      if (!tried.emplace(other.jitter_, other.charge_).second) continue;
      const double at = evidence(other);
      if (!(at > most)) continue;
      most = at;
      found = std::move(other);
    }
  };
  const double step = std::pow(kMost / kLeast, 1.0 / (kGrid - 1)),
               middle = std::sqrt(kMost * kLeast);
  for (const double apart : {step, std::sqrt(step)}) {
    improve(apart < step ? around(found.charge_, apart, 3) : around(middle, apart, kGrid), true);
    improve(apart < step ? around(found.jitter_, apart, 3) : around(middle, apart, kGrid), false);
  }
  return found;
}

InputSequence TimingJitterNoise::weighed(InputSequence inputs, double jitter) {
  const InputSequence measured = inputs;
  for (std::size_t n = 0; n < inputs.samples.size(); ++n)
    if (!(inputs.samples[n].step.span > 0.0))
      inputs.samples[n].count /= 1.0 + jitter * squaredChange(measured, n);
  return inputs;
}

Eigen::MatrixXd NoiseRows::directions(const LinearProblem& problem, const LinearFit& fit,
                                      double effective_sample_fraction) {
  Eigen::VectorXd deviation(problem.products.cols());
  deviation.head(problem.known()) = problem.known_std;
  for (Eigen::Index k = problem.known(); k < deviation.size(); ++k)
    deviation[k] = fit.strength[problem.groupOf(k)];
  const auto axes =
      eigenDecomposition(deviation.asDiagonal() * problem.products * deviation.asDiagonal());
  const auto used = (effective_sample_fraction * axes.eigenvalues().array() >
                     kMinInformation * fit.noise * fit.noise)
                        .count();
  return deviation.asDiagonal() * axes.eigenvectors().rightCols(used);
}

double NoiseRows::evidence(const TimingJitterNoise& noise) const {
  const Eigen::MatrixXd innovations = noise.whitened(columns);
  const Eigen::VectorXd left = noise.whitened(targets);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
  products.selfadjointView<Eigen::Lower>().rankUpdate(innovations.transpose());
  const double of_columns =
      evidenceOfUnitPriors(products, innovations.transpose() * left, left.squaredNorm(),
                           static_cast<double>(left.size()), effective_sample_fraction, level);
  return of_columns + effective_sample_fraction * noise.logScale();
}

}  // namespace battery_sof
