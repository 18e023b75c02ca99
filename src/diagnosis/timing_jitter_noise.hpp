#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "model/input_sequence.hpp"
#include "regression/discrepancy_fit.hpp"
#include "regression/evidence.hpp"

namespace battery_sof {

/**
 * @brief What a slow sampling does not know of a changing current, as noise of rows that are single
 * samples.
 *
 *     e_k = w_k + x_k,   w_k ~ N(0, s^2 (1 + q d_k^2)),   x_k = a_k x_k-1 + s h b_k n_k,   n_k ~ N(0, 1)
 *     d_k^2 = (i_k - i_k-1)^2 + (i_k+1 - i_k)^2,   b_k = |i_k - i_k-1| (t_k - t_k-1)
 *
 * A current that steps between two samples steps at an instant that nobody saw. Two channels that
 * are not looked at in the same instant see it on different sides: w. The charge that it brought is
 * not known: x, on the double layer, forgotten as that forgets (a, Linearization::persistence). q
 * [1/A^2] and h [1/(A s)] are found from the recording itself. Rows of several samples are fast
 * enough to see the step: there both are 0.
 */
class TimingJitterNoise {
 public:
  /// Nothing is unseen.
  TimingJitterNoise() = default;

  /// @param counted rows of the response that are compared, in order.
  TimingJitterNoise(const InputSequence& inputs, const Linearization& response,
                    const std::vector<Eigen::Index>& counted);

  /// @return whether rows are single samples.
  bool applies() const { return change_.size() > 0; }

  /// @return the same rows with q and h.
  TimingJitterNoise with(double jitter, double charge) const;

  /// @return the same rows with q and h of greatest evidence, found one after the other. @param
  /// evidence of a noise, as a logarithm.
  TimingJitterNoise best(const std::function<double(const TimingJitterNoise&)>& evidence) const;

  /// @return whether rows are left as they are.
  bool isWhite() const { return !(jitter_ > 0.0 || charge_ > 0.0); }

  /// @return columns of the counted rows as innovations with the noise s in every row.
  Eigen::MatrixXd whitened(const Eigen::Ref<const Eigen::MatrixXd>& columns) const;

  /// @return sum over the counted rows of ln(s / standard deviation of the innovation).
  double logScale() const;

  double jitter() const { return jitter_; }  ///< q [1/A^2]
  double charge() const { return charge_; }  ///< h [1/(A s)]

  /// @return an input sequence of single samples that count as much less as w is wider. Averaged
  /// ones stay as they are.
  static InputSequence weighed(InputSequence inputs, double jitter);

 private:
  struct Step {
    double retained = 1.0;  // a, from the counted row before
    double brought = 0.0;   // variance of x that came since, over h^2 s^2
  };

  std::vector<Step> steps_;  // of the counted rows
  Eigen::VectorXd change_;   // d^2 [A^2]
  double jitter_ = 0.0, charge_ = 0.0;
  // of the filter, and 1 / standard deviation of the innovation over s
  Eigen::VectorXd gain_, scale_;
};

/**
 * @brief Rows of a linear fit as few columns, to weigh one noise of the rows against another.
 *
 *     y = A z + e,   z = D V u,   u ~ N(0, 1),   D A'A D = V diag(v) V'
 *
 * with the strengths D that a fit to white rows found. Directions that the data do not determine, v
 * below a hundredth of the noise's variance, are left out. The remaining rows, as innovations of a
 * noise, have the evidence of evidenceOfUnitPriors().
 */
struct NoiseRows {
  Eigen::MatrixXd columns;           ///< A D V, rows x directions, white
  Eigen::VectorXd targets;           ///< y
  double effective_sample_fraction;  ///< their weight
  double level;                      ///< noise of the fit [targets' unit]

  /// @return D V, columns x directions: of the directions that the data determine. @param problem
  /// sums of the white columns.
  /// @param fit of them.  @param effective_sample_fraction their weight.
  static Eigen::MatrixXd directions(const LinearProblem& problem, const LinearFit& fit,
                                    double effective_sample_fraction);

  /// @return ln of the marginal likelihood of the rows with a noise whose level is fitted.
  double evidence(const TimingJitterNoise& noise) const;
};

}  // namespace battery_sof
