#pragma once

#include <Eigen/Eigenvalues>

namespace battery_sof {

/**
 * @brief Eigenvalues, increasing, and eigenvectors of a symmetric matrix.
 *
 * A function, because Eigen's solver takes ten seconds to compile in every file that constructs it.
 */
Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigenDecomposition(const Eigen::MatrixXd& symmetric);

}  // namespace battery_sof
