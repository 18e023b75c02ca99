#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

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

}  // namespace battery_sof
