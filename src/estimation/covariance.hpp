#pragma once

#include <Eigen/Core>

namespace battery_sof {

/// @return lag-one autocorrelation of a residual [-1, 1]; 0 for fewer than three samples.
double lagOneCorrelation(const Eigen::VectorXd& residual);

/**
 * @brief Width of the Bartlett kernel for a residual of that autocorrelation (Andrews 1991, AR(1)
 * plug-in).
 *
 *     L = 1.1447 (a n)^(1/3),   a = 4 rho^2 / (1 - rho^2)^2,   1 <= L <= n / 5
 */
Eigen::Index bartlettWidth(double rho, Eigen::Index samples);

/// The two parts of a sandwich: more of either, as of priors, can be added before they are combined.
struct Sandwich {
  Eigen::MatrixXd A, B;
};

/**
 * @brief Covariance of a weighted least-squares estimate whose residuals are neither white nor
 * weighted by their variance, V = A^-1 B A^-1, in its parts.
 *
 *     A = J'W^2J,  B = sum_l (1 - |l|/L) sum_n g_n g_(n-l)',  g_n = W_n^2 e_n J_n   (Newey, West 1987)
 *
 * in one pass: with that kernel B is the mean outer product of L-sample sums of g.
 *
 * @param jacobian n x p, d u_m / d theta.  @param residual n, u_b - u_m.  @param weight n, W^2.
 * @param width L [samples].
 */
Sandwich sandwichParts(const Eigen::Ref<const Eigen::MatrixXd>& jacobian,
                       const Eigen::VectorXd& residual, const Eigen::VectorXd& weight,
                       Eigen::Index width);

/// @return A^-1 B A^-1, p x p, with informationInverse().
Eigen::MatrixXd combined(const Sandwich& parts);

/// @return pseudo-inverse of A after scaling its diagonal to one: rows and columns of parameters that
/// the data say nothing about (zero columns, or directions with an eigenvalue below 1e-12 of the
/// largest) are zero or enlarged as it leaves them.
Eigen::MatrixXd informationInverse(const Eigen::MatrixXd& A);

}  // namespace battery_sof
