#include "util/eigen_decomposition.hpp"

namespace battery_sof {

Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigenDecomposition(
    const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric);
}

}  // namespace battery_sof
