#pragma once

#include <Eigen/Core>
#include <utility>

#include "diagnosis/timing_jitter_noise.hpp"
#include "regression/evidence.hpp"

namespace battery_sof {

/**
 * @brief Rows of a linear fit as few columns, to weigh one noise of the rows against another.
 *
 *     y = A z + e,   z = D V u,   u ~ N(0, 1),   D A'A D = V diag(v) V'
 *
 * with the strengths D that a fit to white rows found. Directions that the data do not determine, v
 * below a hundredth of the noise's variance, are left out. The remaining rows, as innovations of a
 * noise, have the evidence of evidenceOfUnitPriors().
 */
class NoiseRows {
 public:
  /// @return D V, columns x directions: of the directions that the data determine. @param problem
  /// sums of the white columns.
  /// @param fit of them.  @param effective_sample_fraction their weight.
  static Eigen::MatrixXd directions(const LinearProblem& problem, const LinearFit& fit,
                                    double effective_sample_fraction);

  /// @param columns A D V, rows x directions, white.  @param targets y.  @param noise of the fit
  /// [targets' unit].
  NoiseRows(Eigen::MatrixXd columns, Eigen::VectorXd targets, double effective_sample_fraction,
            double noise)
      : columns_(std::move(columns)),
        targets_(std::move(targets)),
        effective_sample_fraction_(effective_sample_fraction),
        noise_(noise) {}

  /// @return ln of the marginal likelihood of the rows with a noise whose level is fitted.
  double evidence(const TimingJitterNoise& noise) const;

 private:
  Eigen::MatrixXd columns_;  // rows x directions
  Eigen::VectorXd targets_;
  double effective_sample_fraction_, noise_;
};

}  // namespace battery_sof
