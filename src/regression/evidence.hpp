#pragma once

#include <Eigen/Core>
#include <vector>

namespace battery_sof {

/**
 * @brief A linear model with independent Gaussian priors, as sums over its rows.
 *
 *     y = A z + e,   z_k ~ N(0, s_k^2),   e ~ N(0, s^2)
 *
 * The first columns have known s_k (what the base circuit's parameters may move by); every other
 * column belongs to a group.
 */
struct LinearProblem {
  Eigen::MatrixXd products;  ///< A'A, columns x columns
  Eigen::VectorXd targets;   ///< A'y
  double square = 0.0;       ///< y'y [V^2]
  double rows = 0.0;
  Eigen::VectorXd known_std;  ///< of the first columns
  std::vector<int> group;     ///< of every further column, from 0
  int groups = 0;
  std::vector<double> most;  ///< [V], strength that each group may have; empty: GroupPrior::kMost

  Eigen::Index known() const { return known_std.size(); }
  /// @param column behind the known ones.
  std::size_t groupOf(Eigen::Index column) const {
    return static_cast<std::size_t>(group[column - known()]);
  }
};

/// What is known beforehand of a group's strength s [V of a column of unit RMS].
struct GroupPrior {
  static constexpr double kScale = 1e-3;  ///< [V]: density falls as 1 / sqrt(1 + (s / kScale)^2)
  static constexpr double kMost = 0.2;    ///< [V]
  static constexpr double kFirst = 2e-3;  ///< [V], where a fit begins
};

/// A fit of a LinearProblem.
struct LinearFit {
  Eigen::VectorXd z;  ///< mean, one a column
  /// s of every group [V]; 0: off. Of a sparse fit: of every free column
  std::vector<double> strength;
  double noise = 0.0;     ///< s of e [V]
  double evidence = 0.0;  ///< ln of the marginal likelihood with the strengths' priors
};

/**
 * @brief Strengths of the groups and noise of greatest evidence (MacKay 1992, one strength a
 * group).
 *
 *     ln p = -n/2 ln(2 pi s^2) - (y'y - h'B^-1 h) / (2 s^2) - ln|B| / 2,   B = 1 + D A'A D / s^2,  D = diag(s_k)
 *
 * times the effective sample fraction: rows whose errors hang together count as fewer. Started from
 * small and from large strengths and from groups taken in one after the other: a single start can
 * be trapped with a group off.
 */
LinearFit fitGroups(const LinearProblem& problem, double effective_sample_fraction);

/// The same with some groups only: those of `active`, others off. Evidence is minus infinity, and z
/// zero, where the products are no numbers.
LinearFit fitSomeGroups(const LinearProblem& problem, double effective_sample_fraction,
                        const std::vector<char>& active);

/// The same from strengths and noise of another fit, such as one at another fraction: no other
/// start is tried.
LinearFit fitGroupsFrom(const LinearProblem& problem, double effective_sample_fraction,
                        const LinearFit& start);

/// @return covariance of z of a fit of all groups at that effective sample fraction; 0 where the
/// products are no numbers.
Eigen::MatrixXd covarianceOf(const LinearProblem& problem, double effective_sample_fraction,
                             const LinearFit& fit);

/**
 * @brief ln p as above of a problem whose columns all have s_k = 1, at the noise s where it is
 * greatest, in the axes of A'A:
 *
 *     ln p = -n/2 ln(2 pi s^2) - (y'y - sum g^2 / (w + s^2)) / (2 s^2) - sum ln(1 + w / s^2) / 2,   A'A = W diag(w) W',   g = W' A'y
 *
 * Every round of the noise is a sum over the axes: for many noises of the same rows.
 * @param products the lower triangle is read.  @param noise where the search begins [V].
 */
double evidenceOfUnitPriors(const Eigen::MatrixXd& products, const Eigen::VectorXd& targets,
                            double square, double rows, double effective_sample_fraction,
                            double noise);

/// A column of a sparse fit in the order in which it came.
struct SparseStep {
  int column = 0;     ///< among the free ones
  double gain = 0.0;  ///< of ln p [1]
};

struct SparseFit {
  LinearFit fit;
  std::vector<SparseStep> path;
};

/// @brief Columns one after the other, each with a strength of its own (Tipping and Faul 2003),
/// while ln p gains more than 1.
SparseFit fitSparse(const LinearProblem& problem, double effective_sample_fraction,
                    int max_columns);

/// @return share of rows that count as independent: 1 / (1 + 2 sum of autocorrelations up to the
/// first not above zero).
double independentShare(const Eigen::VectorXd& residual);

}  // namespace battery_sof
