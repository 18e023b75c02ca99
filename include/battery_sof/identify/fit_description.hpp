#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/identify/fitted_model.hpp"
#include "battery_sof/identify/levenberg_marquardt.hpp"
#include "battery_sof/recording/series.hpp"

namespace battery_sof {

/// @return square root of a diagonal entry; none when it is zero or not finite: nothing is known.
std::optional<double> standardError(const Eigen::MatrixXd& covariance, Eigen::Index row);

/// The model of a window that was not fitted, and why: magnitudes, nothing determined.
FittedModel unfitted(const Series& series, IndexRange range, const std::vector<std::string>& effects,
                     FitStatus status, const std::string& message);

/**
 * @brief Scores of a fit over its window.
 * @param residual u_b - u_m, one a sample of the range [V].  @param rho its lag-one autocorrelation.
 * @param crank_current [A], a crank falls to this or below.
 */
FitScores scoresOf(const Series& series, IndexRange range, const Eigen::VectorXd& residual,
                   double rho, double crank_current);

/// @return the same end in the words of a fit.
FitStatus fitStatusOf(MinimizeStatus status);

/// @return how a fit ended and what it did not determine.
std::string sentenceOf(const FittedModel& model);

}  // namespace battery_sof
