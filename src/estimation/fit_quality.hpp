#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "estimation/composition_fit.hpp"
#include "recording/channel_statistics.hpp"
#include "recording/events.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/// Half a step of the coarsest battery sensor known (25 mV), and what it moves through r_charge's
/// magnitude of 10 mOhm: errors that differ by less are equal.
constexpr double kNegligibleVoltage = 0.0125;  // [V]
constexpr double kNegligibleCurrent = 1.25;    // [A]

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

/// @return root mean square of the difference [V]. @throws as qDyn().
double rootMeanSquareError(const std::vector<double>& measured,
                           const std::vector<double>& predicted);

/// Errors of one quantity over the samples in which it is the battery's answer.
class AnswerErrors {
 public:
  /// @param is_predicted false: the quantity has no prediction, and no error counts.
  explicit AnswerErrors(bool is_predicted = true) : is_predicted_(is_predicted) {}
  void add(double measured, double error) {
    measured_.add(measured);
    squares_ += error * error;
  }
  std::size_t samples() const { return measured_.count(); }
  double rms() const;  ///< 0 of none
  bool isJudged() const { return samples() >= kFewestJudged; }
  /// Sum of their squares in units of the variance of what was measured [1]; none where too few
  /// are there, the quantity never changed, or it has no prediction.
  std::optional<double> relative() const;

 private:
  static constexpr std::size_t kFewestJudged = 6;

  bool is_predicted_;
  RunningVariance measured_;
  double squares_ = 0.0;
};

/// @return 100 (1 - RMS of the errors in units of their quantity's spread), of those that have such;
/// none where none has.
std::optional<double> explainedPercent(const std::vector<AnswerErrors>& quantities);

/// The model of a window that was not fitted, and why: magnitudes, nothing determined. @param
/// excited excitedRange() where that is known.
FittedModel unfitted(const Series& series, IndexRange range, const BatteryModel& composition,
                     FitStatus status, const std::string& message,
                     const std::optional<ExcitedRange>& excited = std::nullopt);

/// The model of a window's optimum, its state at rest; covariance, scores and what conclude() says
/// are still to come. @param excited as of unfitted().
FittedModel modelOf(const Series& series, IndexRange range, const BatteryModel& composition,
                    const CompositionFit& fit,
                    const std::optional<ExcitedRange>& excited = std::nullopt);

/// What a crank is, and where the sensor cuts it off.
struct CrankLimits {
  double current = kCrankCurrent;            ///< [A], a crank falls to this or below
  std::optional<double> sensor_min_current;  ///< [A], ExcitedRange
};

/**
 * @brief Scores of a fit over its window.
 * @param residual u_b - u_m, one a sample of the range [V].  @param rho its lag-one
 * autocorrelation.
 * @param limits of cranks: those that are cut off and do not violate the bound are not scored.
 */
FitScores scoresOf(const Series& series, IndexRange range, const Eigen::VectorXd& residual,
                   double rho, const CrankLimits& limits);

/// Takes the standard errors and says how a fit ended and what it did not determine, once estimates
/// and covariance are there: kNotExcited where nothing but u_dc is determined.
void conclude(Fit& fit);

/**
 * @brief Makes a usable fit one that failed (kImplausible, with the reason) where nothing was
 * determined or its standard errors are none that data can give.
 *
 * The search never moved from its start; or a standard error is below a millionth of what a
 * parameter counts as determined with (determinedBelow()) for each millivolt that the fit leaves,
 * one at most: 10^12 independent samples would be needed.
 */
void requirePlausible(Fit& fit);

/// @return lag-one autocorrelation of a residual, at most 0.9999 in magnitude; 0 for fewer than
/// three samples.
double lagOneCorrelation(const Eigen::VectorXd& residual);

/// The two parts of a sandwich: more of either, as of priors, can be added before they are combined.
struct Sandwich {
  Eigen::MatrixXd A, B;
};

/**
 * @brief Covariance of a weighted least-squares estimate whose residuals are neither white nor
 * weighted by their variance, V = A^-1 B A^-1, in its parts.
 *
 *     A = J'W^2J,   B = f sum_n g_n g_n' + J'W^2 S W^2J,   g_n = W_n^2 e_n J_n                       (White 1980)
 *     S_ij = ar_std^2 exp(-|t_i - t_j| / ar_time) + walk_std^2 min(t_i, t_j),   f = max(1, white_std^2 / mean of e^2)
 *
 * with the NoiseModel that is fitted to means of e over neighbouring rows, 200 at most (fitNoise()).
 * What lasts for seconds is hidden in white noise from neighbouring samples; a kernel as wide as
 * their correlation lasts misses it. f is above 1 where noise lasts for less than a mean.
 *
 * @param jacobian n x p, d u_m / d theta.  @param residual n, u_b - u_m.  @param weight n, W^2; rows
 * without weight do not count.  @param time [s], one a row, not decreasing.
 * @note fewer than 30 rows that count have independent errors.
 */
Sandwich sandwichParts(const Eigen::Ref<const Eigen::MatrixXd>& jacobian,
                       const Eigen::VectorXd& residual, const Eigen::VectorXd& weight,
                       const Eigen::VectorXd& time);

/// @return A^-1 B A^-1, p x p, with informationInverse().
Eigen::MatrixXd combined(const Sandwich& parts);

/// @return pseudo-inverse of A after scaling its diagonal to one: rows and columns of parameters that
/// the data say nothing about (zero columns, or directions with an eigenvalue below 1e-12 of the
/// largest) are zero or enlarged as it leaves them.
Eigen::MatrixXd informationInverse(const Eigen::MatrixXd& A);

}  // namespace battery_sof
