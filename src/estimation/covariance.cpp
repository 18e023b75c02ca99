#include "estimation/covariance.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace battery_sof {
namespace {

constexpr Eigen::Index kBlock = 256;  // rows that stay in the first-level cache

}  // namespace

double lagOneCorrelation(const Eigen::VectorXd& residual) {
  const Eigen::Index n = residual.size();
  if (n < 3) return 0.0;
  const Eigen::VectorXd e = residual.array() - residual.mean();
  const double power = e.squaredNorm();
  return power > 0.0 ? e.head(n - 1).dot(e.tail(n - 1)) / power : 0.0;
}

Eigen::Index bartlettWidth(double rho, Eigen::Index samples) {
  const double bounded = std::clamp(rho, -0.9999, 0.9999);
  const double a = 4.0 * bounded * bounded / std::pow(1.0 - bounded * bounded, 2);
  const double width = std::ceil(1.1447 * std::cbrt(a * static_cast<double>(samples)));
  const double longest = std::max(1.0, std::floor(static_cast<double>(samples) / 5.0));
  return static_cast<Eigen::Index>(std::clamp(width, 1.0, longest));
}

Sandwich sandwichParts(const Eigen::Ref<const Eigen::MatrixXd>& jacobian,
                       const Eigen::VectorXd& residual, const Eigen::VectorXd& weight,
                       Eigen::Index width) {
  const Eigen::Index n = jacobian.rows();
  const Eigen::Index p = jacobian.cols();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(p, p);
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(p, p);
  // Running sums of g; their differences over L samples, zero-padded at both ends, are the kernel's
  // sums.
  Eigen::MatrixXd running(n + 1, p);
  running.row(0).setZero();
  for (Eigen::Index j = 0; j < p; ++j)
    for (Eigen::Index k = 0; k < n; ++k)
      running(k + 1, j) = running(k, j) + residual[k] * weight[k] * jacobian(k, j);
  for (Eigen::Index first = 0; first < n; first += kBlock) {
    const Eigen::Index rows = std::min(kBlock, n - first);
    const auto J = jacobian.middleRows(first, rows);
    A.noalias() += J.transpose() * (weight.segment(first, rows).asDiagonal() * J);
  }
  Eigen::MatrixXd sums;
  for (Eigen::Index first = 0; first < n + width - 1; first += kBlock) {
    const Eigen::Index rows = std::min(kBlock, n + width - 1 - first);
    sums.resize(rows, p);
    for (Eigen::Index k = first; k < first + rows; ++k)
      sums.row(k - first) =
          running.row(std::min(k + 1, n)) - running.row(std::max<Eigen::Index>(0, k + 1 - width));
    B.noalias() += sums.transpose() * sums;
  }
  return {A, B / static_cast<double>(width)};
}

Eigen::MatrixXd informationInverse(const Eigen::MatrixXd& A) {
  const Eigen::VectorXd scale =
      A.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * A *
                                                             scale.asDiagonal());
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
