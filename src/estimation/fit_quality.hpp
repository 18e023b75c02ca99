#pragma once

#include <Eigen/Core>
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

/// @return how a fit ended and what it did not determine.
std::string sentenceOf(const Fit& fit);

}  // namespace battery_sof
