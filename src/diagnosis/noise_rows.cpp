#include "diagnosis/noise_rows.hpp"

#include <Eigen/Eigenvalues>

namespace battery_sof {
namespace {

constexpr double kMinInformation = 1e-2;  // of the noise's variance

Eigen::VectorXd deviationOf(const LinearProblem& problem, const LinearFit& fit) {
  Eigen::VectorXd deviation(problem.products.cols());
  deviation.head(problem.known()) = problem.known_std;
  for (Eigen::Index k = problem.known(); k < deviation.size(); ++k)
    deviation[k] = fit.strength[static_cast<std::size_t>(
        problem.group[static_cast<std::size_t>(k - problem.known())])];
  return deviation;
}

}  // namespace

Eigen::MatrixXd NoiseRows::directions(const LinearProblem& problem, const LinearFit& fit,
                                      double effective_sample_fraction) {
  const Eigen::VectorXd deviation = deviationOf(problem, fit);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(
      deviation.asDiagonal() * problem.products * deviation.asDiagonal());
  const auto used = (effective_sample_fraction * axes.eigenvalues().array() >
                     kMinInformation * fit.noise * fit.noise)
                        .count();
  return deviation.asDiagonal() * axes.eigenvectors().rightCols(used);
}

double NoiseRows::evidence(const TimingJitterNoise& noise) const {
  const Eigen::MatrixXd innovations = noise.whitened(columns_);
  const Eigen::VectorXd left = noise.whitened(targets_);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(columns_.cols(), columns_.cols());
  products.selfadjointView<Eigen::Lower>().rankUpdate(innovations.transpose());
  const double of_columns =
      evidenceOfUnitPriors(products, innovations.transpose() * left, left.squaredNorm(),
                           static_cast<double>(left.size()), effective_sample_fraction_, noise_);
  return of_columns + effective_sample_fraction_ * noise.logScale();
}

}  // namespace battery_sof
