#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

/**
 * @brief A series whose channels may be moved against each other, prepared for responseFeatures().
 *
 * Rows at which the current is cut off are `excluded`: they say nothing of a resistance.
 */
struct ResponseRows {
  std::vector<double> time;     ///< [s]
  std::vector<double> current;  ///< [A], positive into the battery
  std::vector<double> voltage;  ///< [V]
  std::vector<char> excluded;   ///< one a row; its SampleFault, 0 where it is measured
  double interval = 1.0;        ///< [s], median
  double voltage_step = 0.0;    ///< [V], by which a change of voltage may be off
  bool has_source = false;      ///< something charges the battery (ControlModes::seen)
  int moved = 0;                ///< ResponseScale::moved, of the reference
  std::size_t size() const { return time.size(); }
};

/// @return the rows of a series, with what instrumentLimits() and detectControlMode() say of it.
ResponseRows responseRows(const Series& series);

/// @return the rows with the current `rows` later (> 0) or earlier (< 0); the ends repeat.
ResponseRows withCurrentMoved(ResponseRows rows, int later);

/// What is taken from a recording. Each hardly depends on how the battery was driven.
enum ResponseFeature {
  kEdgeResistance,      ///< [Ohm], change of voltage per change of current over 0.1 s or one row
  kSlowEdgeResistance,  ///< [Ohm], the same over twice the time
  kBlockedCurrent,      ///< [A], at which the current dwells while the voltage moves
  kFirstTap,            ///< [1], share of the pulse response three rows before the current's change
  kTaps = 9,            ///< pulse response from three rows before to five rows behind
  kResponseFeatures = kFirstTap + kTaps,
};

/// @return "edge_resistance", "slow_edge_resistance", "blocked_current", "response_-3" to "response_+5".
std::string featureId(std::size_t feature);
/// @return "ohm", "A" or "1".
const char* featureUnit(std::size_t feature);

/// Values with their covariance.
struct ResponseFeatures {
  Eigen::VectorXd value = Eigen::VectorXd::Zero(kResponseFeatures);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kResponseFeatures, kResponseFeatures);
  std::array<bool, kResponseFeatures> known = {};
  /// Whether anything is known. @return number of features.
  std::size_t count() const;
};

/// What features are taken by, the same for every recording that is compared.
struct ResponseScale {
  double current = 1.0;  ///< [1], of the thresholds of current; 1 for a start-stop car
  int moved = 0;         ///< rows by which the current is moved, so that it meets the voltage
};

/// @return the scale of a reference: thresholds shrink with its range of current below 200 A, and
/// the current is moved to the row of the largest pulse response.
ResponseScale responseScale(const ResponseRows& reference);

/**
 * @brief What a recording shows of battery and instruments whatever the drive.
 *
 * - Resistances: the location of dv/di over changes of current of 8 A and more with discharge (below
 *   -4 A) before and behind, by a Cauchy likelihood of scale sqrt(w^2 + (s / di)^2), w: scatter of the
 *   ratios, s: a step of the voltage's channel, 4 mV at least.
 * - Blocked current: the mode, with a Gaussian kernel of 0.3 A, of the current within 11 A while the
 *   voltage moves by more than 40 mV in 3 s. A charger moves the voltage of a battery that neither
 *   charges nor discharges without a current of its reaction (docs/physics.md#charge_acceptance):
 *   what the sensor reads then is its offset, and a small constant current of the battery's own.
 *   Without a charger it is unknown.
 * - Pulse response: coefficients h_j of
 *
 *       v(n) - v(n-1) = sum_j h_j (i(n-j) - i(n-j-1)),   j = -3 ... 5
 *
 *   by weighted least squares over rows with a change of 8 A among them, over sum |h_j|.
 *
 * The covariance is that of a jackknife over eight blocks of time, not below the scatter's own.
 *
 * @param rows any sampling; a feature is unknown with fewer than 12 changes of current, 50 rows of
 * blocked current, or 60 rows of pulse response.
 */
ResponseFeatures responseFeatures(const ResponseRows& rows, const ResponseScale& scale);

/// @return mean of the features of several recordings, of those that know each.
ResponseFeatures meanOf(const std::vector<ResponseFeatures>& all);

}  // namespace battery_sof
