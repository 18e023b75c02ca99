#include "battery_sof/diagnose/noise_rows.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

namespace battery_sof {
namespace {

constexpr double kTold = 1e-2;        // of the noise's variance
constexpr double kLeastNoise = 3e-5;  // [V]
constexpr double kTwoPi = 6.283185307179586;
constexpr double kSettled = 1e-4;  // of the noise
constexpr int kRounds = 60;

Eigen::VectorXd deviationOf(const LinearProblem& problem, const LinearFit& fit) {
  Eigen::VectorXd deviation(problem.products.cols());
  deviation.head(problem.known()) = problem.known_std;
  for (Eigen::Index k = problem.known(); k < deviation.size(); ++k)
    deviation[k] = fit.strength[static_cast<std::size_t>(problem.group[static_cast<std::size_t>(k - problem.known())])];
  return deviation;
}

}  // namespace

NoiseRows::NoiseRows(const LinearProblem& problem, const Eigen::MatrixXd& columns, Eigen::VectorXd targets, const LinearFit& fit,
                     double temper)
    : targets_(std::move(targets)), temper_(temper), noise_(fit.noise) {
  const Eigen::VectorXd deviation = deviationOf(problem, fit);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> told(deviation.asDiagonal() * problem.products * deviation.asDiagonal());
  const auto used = (temper * told.eigenvalues().array() > kTold * noise_ * noise_).count();
  columns_ = columns * (deviation.asDiagonal() * told.eigenvectors().rightCols(used));
}

double NoiseRows::evidence(const EdgeNoise& noise) const {
  Eigen::MatrixXd innovations(columns_.rows(), columns_.cols());
  for (Eigen::Index k = 0; k < columns_.cols(); ++k) innovations.col(k) = noise.whitened(columns_.col(k));
  const Eigen::VectorXd left = noise.whitened(targets_);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(columns_.cols(), columns_.cols());
  products.selfadjointView<Eigen::Lower>().rankUpdate(innovations.transpose(), temper_);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(products);
  const Eigen::ArrayXd told = axes.eigenvalues().array().max(0.0);
  const Eigen::ArrayXd squares = (temper_ * (axes.eigenvectors().transpose() * (innovations.transpose() * left))).array().square();
  const double square = temper_ * left.squaredNorm(), rows = temper_ * static_cast<double>(left.size());
  double s = noise_;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::ArrayXd kept = told + s * s;
    const double residual = square - (2.0 * squares / kept - told * squares / kept.square()).sum();
    const double fixed = (told / kept).sum();
    const double before = std::exchange(s, std::max(kLeastNoise, std::sqrt(std::max(residual, 0.0) / std::max(rows - fixed, 0.1 * rows))));
    if (std::abs(s - before) < kSettled * before) break;
  }
  const Eigen::ArrayXd kept = told + s * s;
  return -0.5 * rows * std::log(kTwoPi * s * s) - 0.5 * (square - (squares / kept).sum()) / (s * s) - 0.5 * (kept / (s * s)).log().sum() +
         temper_ * noise.logScale();
}

}  // namespace battery_sof
