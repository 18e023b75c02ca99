#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "recording/events.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/**
 * @brief Explained variation of the voltage (paper, eq. 6).
 *
 *     Q_dyn = 100 % (1 - sqrt(sum e^2) / sqrt(sum (u_b - mean u_b)^2))
 *
 * @param measured, predicted [V], same length, not empty.
 * @return [%], at most 100, negative when a constant would do better; none when the measured
 * voltage never changes.
 * @throws std::invalid_argument when the lengths differ or are zero.
 */
std::optional<double> qDyn(const std::vector<double>& measured,
                           const std::vector<double>& predicted);

/// @return qDyn() of what is measured [V], not empty. @param squares sum of the squared errors
/// [V^2].
std::optional<double> qDyn(const Eigen::Map<const Eigen::ArrayXd>& measured, double squares);

/// @return root mean square of the difference [V]. @throws as qDyn().
double rootMeanSquareError(const std::vector<double>& measured,
                           const std::vector<double>& predicted);

/// @return square root of a diagonal entry; none when it is zero or not finite: nothing is known.
std::optional<double> standardError(const Eigen::MatrixXd& covariance, Eigen::Index row);

/// The model of a window that was not fitted, and why: magnitudes, nothing determined.
FittedModel unfitted(const Series& series, IndexRange range, const BatteryModel& composition,
                     FitStatus status, const std::string& message);

/// The same where excitedRange() of the range is known.
FittedModel unfitted(const Series& series, IndexRange range, const ExcitedRange& excited,
                     const BatteryModel& composition, FitStatus status, const std::string& message);

/**
 * @brief Scores of a fit over its window.
 * @param residual u_b - u_m, one a sample of the range [V].  @param rho its lag-one
 * autocorrelation.
 * @param crank_current [A], a crank falls to this or below.
 */
FitScores scoresOf(const Series& series, IndexRange range, const Eigen::VectorXd& residual,
                   double rho, double crank_current);

/// What the scores of a fit are made of.
struct FitErrors {
  double squares = 0.0;        ///< sum of the residual's over the range [V^2]
  double rho = 0.0;            ///< the residual's lag-one autocorrelation
  std::vector<double> cranks;  ///< measured less modelled minimum of each crank [V]
};

/// The same. @param interval [s], medianInterval(series).
FitScores scoresOf(const Series& series, IndexRange range, const FitErrors& errors,
                   double interval);

/// @return measured less modelled minimum of each crank [V]. @param first of the range.  @param
/// residualAt [V], of its n-th sample.
template <typename ResidualAt>
std::vector<double> crankErrors(const Series& series, std::size_t first,
                                const std::vector<Event>& cranks, ResidualAt&& residualAt) {
  std::vector<double> errors;
  for (const Event& crank : cranks) {
    double modelled = std::numeric_limits<double>::infinity();
    for (std::size_t n = crank.range.first; n < crank.range.last; ++n)
      modelled = std::min(modelled, series.voltage[n] - residualAt(n - first));
    errors.push_back(crank.min_voltage - modelled);
  }
  return errors;
}

/// @return how a fit ended and what it did not determine.
std::string sentenceOf(const Fit& fit);

}  // namespace battery_sof
